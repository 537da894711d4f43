// Which stored sites are worth a new look first.
#include <cmath>

#include <doctest/doctest.h>

#include "tests/server/meadow.h"
#include "tests/server/site_on_map.h"

namespace freelsd {
namespace {

constexpr int64_t kDayUs = 86400000000;
constexpr double kDayS = 86400.0;
constexpr double kHalfLifeDays = 365.0;
// An hour of age changes no gain by more.
constexpr double kMaxGainError = 1e-4;

struct Kept {
  std::string id;
  std::string verdict;
  double score = 0.0;
  int64_t age_days = 0;
  double north_m = 0.0;
  bool is_superseded = false;
};

SiteRow RowOf(const Kept& kept) {
  SiteRow site = MeadowSite("amsl", kept.north_m);
  site.id = kept.id;
  nlohmann::json feature = nlohmann::json::parse(site.feature_json);
  feature["properties"]["id"] = kept.id;
  feature["properties"]["verdict"] = kept.verdict;
  feature["properties"]["score"] = kept.score;
  feature["geometry"]["coordinates"][1] = site.latitude_deg;
  site.feature_json = feature.dump();
  if (kept.is_superseded) static_cast<Standing&>(site) = SupersededBy("new-good");
  site.seen_at_us = NowUs() - kept.age_days * kDayUs;
  // Evaluated again today: this is no new look.
  site.updated_at_us = NowUs();
  return site;
}

// The meadow's own sites are deleted: they are not what is tested.
struct KeptServer {
  MeadowServer meadow;

  explicit KeptServer(const std::vector<Kept>& sites)
      : meadow([&sites](Storage& storage) {
          storage.sites.Delete("f-r1");
          for (const Kept& kept : sites) PutWithoutMap(storage, RowOf(kept));
        }) {}

  nlohmann::json List(const std::string& more = "") const {
    return GetJson(*meadow.client, "/v1/sites?order=new_look" + more);
  }
};

double GainOf(double value, double age_days) {
  return value * (1.0 - std::exp2(-age_days / kHalfLifeDays));
}

std::vector<std::string> IdsOf(const nlohmann::json& collection) {
  std::vector<std::string> ids;
  for (const nlohmann::json& feature : collection["features"]) {
    ids.push_back(feature["properties"]["id"]);
  }
  return ids;
}

const std::vector<Kept> kThree{{"new-good", "landable", 0.9, 5},
                               {"old-good", "landable", 0.6, 365, 3000.0},
                               {"old-doubtful", "unverified", 0.8, 600, 6000.0}};

TEST_CASE("new look: sites are ordered by age times value, and each says why") {
  const KeptServer server(kThree);
  const nlohmann::json list = server.List();
  // Gains of 0.300, 0.272 (an unverified score counts half) and 0.009.
  REQUIRE(IdsOf(list) == std::vector<std::string>{"old-good", "old-doubtful", "new-good"});
  const std::vector<std::pair<double, double>> value_and_days{{0.6, 365}, {0.4, 600}, {0.9, 5}};
  for (size_t i = 0; i < value_and_days.size(); ++i) {
    CAPTURE(i);
    const double value = value_and_days[i].first, age_days = value_and_days[i].second;
    const nlohmann::json& properties = list["features"][i]["properties"];
    const nlohmann::json& told = properties["new_look"];
    CHECK(told["value"].get<double>() == doctest::Approx(value));
    CHECK(std::abs(told["age_s"].get<double>() - age_days * kDayS) < 3600.0);
    CHECK(std::abs(told["gain"].get<double>() - GainOf(value, age_days)) < kMaxGainError);
    CHECK(properties["age_s"] == told["age_s"]);
    CHECK(properties["rank"] == i + 1);
    const std::string days = std::to_string(static_cast<int>(age_days)) + " days";
    CHECK(told["sentence"].get<std::string>().find(days) != std::string::npos);
  }
  // Only this order tells it.
  CHECK_FALSE(GetJson(*server.meadow.client, "/v1/sites")["features"][0]["properties"].contains(
      "new_look"));
}

TEST_CASE("new look: what is rejected or superseded is not worth one, a box cuts the list") {
  std::vector<Kept> sites = kThree;
  sites.push_back({"rejected", "rejected", 0.9, 2000});
  sites.push_back({"superseded", "landable", 0.9, 2000, 0.0, true});
  const KeptServer server(sites);
  CHECK(IdsOf(server.List()).size() == 3);
  CHECK(IdsOf(server.List("&bbox=7.9,46.9,8.1,47.01")) == std::vector<std::string>{"new-good"});
  CheckProblem(server.meadow.client->Get("/v1/sites?order=new_look&include=superseded"),
               400,
               "InvalidQuery");
  CheckProblem(server.meadow.client->Get("/v1/sites?order=age"), 400, "InvalidQuery");
}

TEST_CASE("new look: a smaller limit is a prefix, pages are parts, ties are ordered by id") {
  std::vector<Kept> sites;
  sites.reserve(12);
  for (int i = 0; i < 9; ++i) {
    sites.push_back({"s" + std::to_string(i), "landable", 0.1 * (1 + i % 3), 100 * (1 + i % 2)});
  }
  // Photographs of the future have no age: gains of 0 are ties.
  for (const char* const id : {"z", "y", "x"}) sites.push_back({id, "landable", 0.7, -10});
  const KeptServer server(sites);
  const std::vector<std::string> whole = IdsOf(server.List());
  REQUIRE(whole.size() == sites.size());
  CHECK(std::vector<std::string>(whole.end() - 3, whole.end()) ==
        std::vector<std::string>{"x", "y", "z"});
  for (size_t limit = 1; limit <= whole.size(); ++limit) {
    CAPTURE(limit);
    std::vector<std::string> joined;
    std::string cursor;
    do {
      const nlohmann::json page = server.List("&limit=" + std::to_string(limit) + cursor);
      const std::vector<std::string> ids = IdsOf(page);
      for (const nlohmann::json& feature : page["features"]) {
        joined.push_back(feature["properties"]["id"]);
        CHECK(feature["properties"]["rank"] == joined.size());
      }
      CHECK(ids.size() <= limit);
      cursor = page.contains("next") ? "&cursor=" + page["next"].get<std::string>() : "";
    } while (!cursor.empty() && joined.size() <= whole.size());
    CHECK(joined == whole);
  }
  for (const std::string cursor : {"x", "0~1", "1~x~y", "9000000000000000000~-0.5~s1", "-1~0~a"}) {
    CAPTURE(cursor);
    CheckProblem(server.meadow.client->Get("/v1/sites?order=new_look&cursor=" + cursor),
                 400,
                 "InvalidQuery");
  }
}

}  // namespace
}  // namespace freelsd
