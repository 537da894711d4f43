// freelsd-fly-over: simulated flights over a row of fields. It tells a server what it would have
// found, minute by minute of a simulated hour: new sites, sites that later maps supersede or
// confirm, obstacles that come, go and expire, and sites that are deleted. Or it asks for sites and
// tells how long the answers took.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <random>
#include <thread>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "server/http/http.h"
#include "tests/server/following/simulated_flight.h"

namespace freelsd {
namespace {

constexpr int64_t kMinuteUs = 60'000'000;
// Of the simulated hour.
constexpr int64_t kBeginUs = 1'750'000'000'000'000;
constexpr double kFieldsApartDeg = 0.02;

struct Options {
  std::string to;
  std::string name = "aircraft";
  std::string token_file;
  uint64_t seed = 1;
  int first_minute = 0;
  int num_minutes = 60;
  int num_fields = 12;
  int num_recalls = 0;
};

double LongitudeOf(int field) { return 8.0 + kFieldsApartDeg * field; }

class FlyOver {
 public:
  explicit FlyOver(const Options& options)
      : options_(options), client_(options.to), random_(options.seed) {
    client_.set_keep_alive(true);
    client_.set_tcp_nodelay(true);
    client_.set_read_timeout(60);
    if (options.token_file.empty()) return;
    std::string token;
    std::getline(std::ifstream(options.token_file) >> std::ws, token);
    client_.set_bearer_token_auth(token);
  }

  void Fly() {
    for (int minute = 0; minute < options_.num_minutes; ++minute) {
      FlyOne(options_.first_minute + minute);
      ChangeObstacle();
    }
    std::printf("%s: %d flights, %d of them over walls, %d sites deleted, %d obstacle changes\n",
                options_.name.c_str(),
                num_flights_,
                num_walls_,
                num_deleted_,
                num_obstacles_);
  }

  // From 700 m above the fields.
  void Recall() {
    std::vector<double> took_ms;
    for (int i = 0; i < options_.num_recalls; ++i) {
      const int field = Below(options_.num_fields);
      const std::string path =
          "/v1/emergency?latitude_deg=46.99&longitude_deg=" + std::to_string(LongitudeOf(field)) +
          "&altitude_m=1100&altitude_datum=amsl&wind_east_mps=0"
          "&wind_north_mps=-4&heading_deg=0";
      const auto begin = std::chrono::steady_clock::now();
      Expect(client_.Get(path), path);
      took_ms.push_back(
          std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin)
              .count());
    }
    std::sort(took_ms.begin(), took_ms.end());
    const auto at = [&](double ratio) {
      return took_ms[static_cast<size_t>(ratio * static_cast<double>(took_ms.size() - 1))];
    };
    std::printf("%s: %zu recalls, p50 %.1f ms, p99 %.1f ms, longest %.1f ms\n",
                options_.name.c_str(),
                took_ms.size(),
                at(0.5),
                at(0.99),
                took_ms.back());
  }

 private:
  int Below(int bound) { return std::uniform_int_distribution<int>(0, bound - 1)(random_); }

  static void Expect(const httplib::Result& result, const std::string& what) {
    if (result && result->status >= 200 && result->status < 300) return;
    throw std::runtime_error(what + ": " + (result ? result->body : "no answer"));
  }

  void FlyOne(int minute) {
    SimulatedFlight flight;
    flight.id = options_.name + "-" + std::to_string(minute);
    flight.longitude_deg = LongitudeOf(Below(options_.num_fields));
    flight.seen_at_us = kBeginUs + minute * kMinuteUs + Below(1000);
    flight.origin = options_.name;
    flight.has_site = Below(3) > 0;
    if (!flight.has_site && Below(4) > 0) flight.field = FieldState::kWalled;
    const ToldFlight told = freelsd::Fly(flight);
    ++num_flights_;
    if (flight.field == FieldState::kWalled) ++num_walls_;
    for (const auto& [id, bytes] : told.map_bytes) {
      const std::string path = "/v1/maps/" + id;
      Expect(client_.Put(path, bytes, "application/octet-stream"), path);
    }
    nlohmann::json body{{"changes", nlohmann::json::array()}};
    for (const ToldChange& change : told.changes) {
      body["changes"].push_back(ToldJson(change, options_.name));
    }
    Expect(client_.Post("/v1/changes", body.dump(), "application/json"), "/v1/changes");
    if (flight.has_site) sites_.push_back(flight.id + "-r1");
    if (!sites_.empty() && Below(12) == 0) DeleteSite();
  }

  void DeleteSite() {
    const size_t which = static_cast<size_t>(Below(static_cast<int>(sites_.size())));
    const std::string path = "/v1/sites/" + sites_[which];
    sites_.erase(sites_.begin() + static_cast<std::ptrdiff_t>(which));
    const httplib::Result result = client_.Delete(path);
    if (result && result->status == 404) return;
    Expect(result, path);
    ++num_deleted_;
  }

  // Of a few that every aircraft knows, and of some of its own.
  void ChangeObstacle() {
    const bool is_shared = Below(3) == 0;
    const std::string id = is_shared ? "mast-" + std::to_string(Below(4))
                                     : options_.name + "-mast-" + std::to_string(Below(8));
    const std::string path = "/v1/obstacles/" + id;
    ++num_obstacles_;
    if (Below(4) == 0) {
      const httplib::Result result = client_.Delete(path);
      if (!result || result->status != 404) Expect(result, path);
      return;
    }
    nlohmann::json properties{{"kind", "mast"}, {"height_m", 20 + Below(60)}};
    if (Below(4) == 0) {
      properties = {{"kind", "people"}, {"expires_at", Rfc3339(NowUs() + 2'000'000)}};
    }
    const nlohmann::json feature{
        {"type", "Feature"},
        {"geometry",
         {{"type", "Point"},
          {"coordinates", {LongitudeOf(Below(options_.num_fields)) + 0.001 * Below(5), 47.004}}}},
        {"properties", properties}};
    Expect(client_.Put(path, feature.dump(), "application/geo+json"), path);
  }

  const Options options_;
  httplib::Client client_;
  std::mt19937_64 random_;
  std::vector<std::string> sites_;
  int num_flights_ = 0, num_walls_ = 0, num_deleted_ = 0, num_obstacles_ = 0;
};

}  // namespace
}  // namespace freelsd

// NOLINTNEXTLINE(bugprone-exception-escape): what is printed is short.
int main(int argc, char** argv) {
  freelsd::Options options;
  CLI::App app("Simulated flights over a row of fields.", "freelsd-fly-over");
  app.add_option("--to", options.to, "URL of the server")->required();
  app.add_option("--name", options.name, "Of the aircraft; begins the ids of its flights");
  app.add_option("--token-file", options.token_file, "File with a token");
  app.add_option("--seed", options.seed);
  app.add_option("--first-minute", options.first_minute);
  app.add_option("--minutes", options.num_minutes);
  app.add_option("--fields", options.num_fields);
  app.add_option("--recalls", options.num_recalls, "Ask so often for sites instead");
  CLI11_PARSE(app, argc, argv);
  try {
    freelsd::FlyOver fly_over(options);
    if (options.num_recalls > 0) {
      fly_over.Recall();
    } else {
      fly_over.Fly();
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "freelsd-fly-over: %s\n", error.what());
    return 1;
  }
  return 0;
}
