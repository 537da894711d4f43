// Lists of alternates: fair between flights, and never out of date: by arrival of the aircraft's
// data, and by every change of the stored sites.
#include "server/recall/alternates.h"

#include <atomic>
#include <chrono>
#include <cmath>
#include <thread>

#include <doctest/doctest.h>

#include "server/http/stamps.h"
#include "server/intake/telemetry.h"
#include "tests/server/meadow.h"
#include "tests/server/sample_flight.h"
#include "tests/server/site_on_map.h"

namespace freelsd {
namespace {

std::string NewAmslFlight(httplib::Client& client) {
  const auto made =
      client.Post("/v1/flights",
                  R"({"name":"x","altitude_datum":"amsl","aircraft":{"profile":"small"}})",
                  "application/json");
  return nlohmann::json::parse(made->body)["id"];
}

std::string LineAt(int64_t timestamp_us, double altitude_m) {
  return nlohmann::json{
      {"timestamp_us", timestamp_us},
      {"position", {{"latitude_deg", 46.9955}, {"longitude_deg", 8.0}, {"altitude_m", altitude_m}}},
      {"wind", {{"east_mps", 0.0}, {"north_mps", 0.0}}}}
      .dump();
}

nlohmann::json PostLine(httplib::Client& client,
                        const std::string& flight,
                        const std::string& line) {
  const auto answer =
      client.Post("/v1/flights/" + flight + "/telemetry", line + "\n", "application/x-ndjson");
  REQUIRE(answer);
  REQUIRE(answer->status == 200);
  return nlohmann::json::parse(answer->body);
}

std::string PathOf(const std::string& flight) { return "/v1/flights/" + flight + "/alternates"; }

bool HasWarning(const nlohmann::json& answer, const std::string& part) {
  return answer["warnings"].dump().find(part) != std::string::npos;
}

void StoreAmslMeadow(Storage& storage) { PutOnMap(storage, MeadowSite("amsl"), Meadow()); }

// A second and a third place, so far north of the first.
void StoreThreeMeadows(Storage& storage) {
  StoreAmslMeadow(storage);
  for (int i = 2; i <= 3; ++i) {
    SiteRow site = MeadowSite("amsl", 700.0 * (i - 1));
    site.id = "f-r" + std::to_string(i);
    PutOnMap(storage, site, Meadow());
  }
}

// True if the list of alternates satisfies the condition within the time.
template <class Condition>
bool Becomes(httplib::Client& client,
             const std::string& flight,
             std::chrono::milliseconds within,
             const Condition& condition) {
  const auto deadline = std::chrono::steady_clock::now() + within;
  while (std::chrono::steady_clock::now() < deadline) {
    if (condition(GetJson(client, PathOf(flight)))) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

TEST_CASE("alternates: a flight that is never silent does not starve the others") {
  const TemporaryFolder folder;
  Storage storage(StorageAt(folder.path()));
  MapCache maps({1 << 20, 1 << 20});
  EventLog events;
  // Its id comes first.
  for (const char* const id : {"a", "b", "c"}) {
    FlightRow flight;
    flight.id = id;
    flight.request_json = ParseFlightRequest(R"({"name":"x"})").canonical_json;
    storage.flights.Insert(flight);
  }
  Alternates alternates(storage, maps, events, 3);
  alternates.Start();
  std::atomic<bool> is_done{false};
  std::thread chatterer([&] {
    while (!is_done) {
      alternates.Wake("a");
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  });
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  alternates.Wake("b");
  alternates.Wake("c");
  std::this_thread::sleep_for(std::chrono::milliseconds(700));
  CHECK(alternates.Kept("a"));
  CHECK(alternates.Kept("b"));
  CHECK(alternates.Kept("c"));
  is_done = true;
  chatterer.join();
  alternates.Stop();
}

// People all over the meadow, for some seconds.
void PutPeople(httplib::Client& client, std::chrono::seconds for_time) {
  const int64_t until_us =
      NowUs() + std::chrono::duration_cast<std::chrono::microseconds>(for_time).count();
  const nlohmann::json ring{
      {7.996, 46.997}, {8.004, 46.997}, {8.004, 47.003}, {7.996, 47.003}, {7.996, 46.997}};
  const nlohmann::json people{
      {"type", "Feature"},
      {"geometry", {{"type", "Polygon"}, {"coordinates", nlohmann::json::array({ring})}}},
      {"properties", {{"kind", "people"}, {"expires_at", Rfc3339(until_us)}}}};
  const auto put = client.Put("/v1/obstacles/people", people.dump(), "application/geo+json");
  INFO(put->body);
  REQUIRE(put->status == 201);
}

// Whether a list with the site is told by an event, without anybody asking.
bool IsToldOfSite(const TestServer& server, const std::string& flight) {
  httplib::Client client = server.Client();
  client.set_read_timeout(8);
  std::string heard;
  client.Get("/v1/events?flight=" + flight, [&](const char* bytes, size_t size) {
    heard.append(bytes, size);
    return heard.find("\"site_id\":\"f-r1\"") == std::string::npos && heard.size() < 100000;
  });
  return heard.find("\"site_id\":\"f-r1\"") != std::string::npos;
}

TEST_CASE(
    "alternates: an obstacle that expires gives the site back, also if the aircraft is silent") {
  const MeadowServer meadow(StoreAmslMeadow);
  httplib::Client& client = *meadow.client;
  const std::string flight = NewAmslFlight(client);
  PutPeople(client, std::chrono::seconds(3));
  const auto begin = std::chrono::steady_clock::now();
  PostLine(client, flight, LineAt(1, 900.0));
  REQUIRE(Becomes(client, flight, std::chrono::seconds(2), [](const nlohmann::json& answer) {
    return answer.contains("pose") && answer["sites"].empty();
  }));
  CHECK(IsToldOfSite(*meadow.server, flight));
  CHECK(GetJson(client, PathOf(flight))["sites"].size() == 1);
  CHECK(std::chrono::steady_clock::now() - begin < std::chrono::seconds(6));
}

TEST_CASE("alternates: a sample far ahead of the server's clock is refused, the past is not") {
  const MeadowServer meadow(StoreAmslMeadow);
  httplib::Client& client = *meadow.client;
  const std::string flight = NewAmslFlight(client);
  constexpr int64_t kYear2255Us = 9000000000000000;
  const nlohmann::json ahead = PostLine(client, flight, LineAt(kYear2255Us, 500.0));
  CHECK(ahead["accepted"] == 0);
  CHECK(ahead["rejected"][0]["detail"].get<std::string>().find("ahead of the server's clock") !=
        std::string::npos);
  CHECK(PostLine(client, flight, LineAt(1700000000000000, 900.0))["accepted"] == 1);
  CHECK(Becomes(client, flight, std::chrono::seconds(10), [](const nlohmann::json& answer) {
    return answer.contains("pose") && answer["pose"]["altitude_m"] == 900.0;
  }));
}

TEST_CASE("alternates: of poses of another day the latest is the one that arrived last") {
  const MeadowServer meadow(StoreAmslMeadow);
  httplib::Client& client = *meadow.client;
  const std::string flight = NewAmslFlight(client);
  PostLine(client, flight, LineAt(1700000000000000, 900.0));
  PostLine(client, flight, LineAt(1600000000000000, 850.0));
  CHECK(Becomes(client, flight, std::chrono::seconds(10), [](const nlohmann::json& answer) {
    return answer.contains("pose") && answer["pose"]["altitude_m"] == 850.0;
  }));
  const nlohmann::json answer = GetJson(client, PathOf(flight));
  CHECK(answer["pose"]["timestamp_us"] == 1600000000000000);
  CHECK(answer["pose"]["age_s"] < 60.0);
  // A wind of another day does not blow now.
  CHECK(answer["wind"]["timestamp_us"] == 1700000000000000);
  CHECK(answer["wind"]["age_s"] > 365.0 * 86400.0);
  CHECK(answer["wind"]["counts_as"] == "unknown");
}

TEST_CASE("alternates: ages go on while the aircraft is silent") {
  const MeadowServer meadow(StoreAmslMeadow);
  httplib::Client& client = *meadow.client;
  const std::string flight = NewAmslFlight(client);
  PostLine(client, flight, LineAt(1700000000000000, 900.0));
  REQUIRE(Becomes(client, flight, std::chrono::seconds(10), [](const nlohmann::json& answer) {
    return answer["sites"].size() == 1;
  }));
  constexpr double kSilentS = 0.5;
  nlohmann::json before, after;
  // On a busy machine the list of the last pose may still be computed.
  for (int i = 0; i < 20 && (i == 0 || after["updated_at"] != before["updated_at"]); ++i) {
    before = GetJson(client, PathOf(flight));
    std::this_thread::sleep_for(std::chrono::duration<double>(kSilentS));
    after = GetJson(client, PathOf(flight));
  }
  const auto age = [](const nlohmann::json& part) { return part["age_s"].get<double>(); };
  CHECK(age(after["pose"]) >= age(before["pose"]) + kSilentS);
  CHECK(age(after["wind"]) >= age(before["wind"]) + kSilentS);
  CHECK(age(after["sites"][0]) >= age(before["sites"][0]) + kSilentS);
  // The list itself did not change.
  CHECK(after["updated_at"] == before["updated_at"]);
}

TEST_CASE("alternates: turns begin with the track over ground, never with an attitude's yaw") {
  const MeadowServer meadow(StoreAmslMeadow);
  httplib::Client& client = *meadow.client;
  const std::string flight = NewAmslFlight(client);
  // Ten metres a second to the north, the nose to the south; the last place is that of LineAt.
  const auto fly = [&](int64_t from_us, double step_m) {
    std::string lines;
    for (int i = 0; i <= 4; ++i) {
      nlohmann::json line = nlohmann::json::parse(LineAt(from_us + i * int64_t{1000000}, 900.0));
      line["position"]["latitude_deg"] = 46.9955 - (4 - i) * step_m / 111195.0;
      line["attitude"] = {{"roll_deg", 0.0}, {"pitch_deg", 0.0}, {"yaw_deg", 180.0}};
      lines += line.dump() + "\n";
    }
    PostLine(client, flight, lines);
  };
  fly(1700000000000000, 0.5);
  REQUIRE(Becomes(client, flight, std::chrono::seconds(10), [](const nlohmann::json& answer) {
    return answer["sites"].size() == 1;
  }));
  const nlohmann::json standing = GetJson(client, PathOf(flight));
  CHECK_FALSE(standing["pose"].contains("heading_deg"));
  CHECK(HasWarning(standing, "the worst turn is assumed"));
  fly(1700000100000000, 10.0);
  nlohmann::json flying;
  REQUIRE(Becomes(client, flight, std::chrono::seconds(3), [&](const nlohmann::json& answer) {
    flying = answer;
    return answer["pose"].contains("heading_deg");
  }));
  const double heading_deg = flying["pose"]["heading_deg"];
  CHECK(std::abs(std::remainder(heading_deg, 360.0)) < 1.0);
  CHECK_FALSE(HasWarning(flying, "the worst turn is assumed"));
  const double margin_m = flying["sites"][0]["arrival_margin_m"];
  CHECK(margin_m > standing["sites"][0]["arrival_margin_m"].get<double>());
  // Since then the aircraft may have turned.
  CHECK(Becomes(client, flight, std::chrono::seconds(10), [](const nlohmann::json& answer) {
    return !answer["pose"].contains("heading_deg") &&
           HasWarning(answer, "the worst turn is assumed");
  }));
  CHECK(GetJson(client, PathOf(flight))["pose"]["age_s"] > 3.0);
}

TEST_CASE("alternates: their number is the configured one, or the query's") {
  const MeadowServer meadow(StoreThreeMeadows, [](Config& config) { config.num_alternates = 2; });
  httplib::Client& client = *meadow.client;
  const std::string flight = NewAmslFlight(client);
  PostLine(client, flight, LineAt(1700000000000000, 1500.0));
  REQUIRE(Becomes(client, flight, std::chrono::seconds(30), [](const nlohmann::json& answer) {
    return answer["sites"].size() == 2;
  }));
  const auto ids = [&](const std::string& query) {
    std::vector<std::string> found;
    const nlohmann::json answer = GetJson(client, PathOf(flight) + query);
    for (const auto& site : answer["sites"]) found.push_back(site["site_id"]);
    return found;
  };
  const std::vector<std::string> all = ids("?limit=3");
  REQUIRE(all.size() == 3);
  CHECK(ids("") == std::vector<std::string>(all.begin(), all.begin() + 2));
  CHECK(ids("?limit=1") == std::vector<std::string>{all[0]});
  CHECK(ids("?limit=20") == all);
  for (const char* const limit : {"0", "21", "1.5", "-1", "1e1"}) {
    CheckProblem(client.Get(PathOf(flight) + "?limit=" + limit), 422, "InvalidValue");
  }
  CheckProblem(client.Get(PathOf(flight) + "?limit=all"), 400, "InvalidQuery");
  CHECK(GetJson(client, "/v1/info")["limits"]["max_num_alternates"] == 20);
  CHECK(GetJson(client, "/v1/info")["limits"]["num_alternates"] == 2);
}

TEST_CASE("alternates: a site is gone from the list when its deletion is answered") {
  const MeadowServer meadow(StoreThreeMeadows);
  httplib::Client& client = *meadow.client;
  const std::string flight = NewAmslFlight(client);
  PostLine(client, flight, LineAt(1700000000000000, 1500.0));
  REQUIRE(Becomes(client, flight, std::chrono::seconds(30), [](const nlohmann::json& answer) {
    return answer["sites"].size() == 3;
  }));
  for (size_t num_left = 3; num_left > 0; --num_left) {
    const nlohmann::json sites = GetJson(client, PathOf(flight))["sites"];
    REQUIRE(sites.size() == num_left);
    const std::string first = sites[0]["site_id"];
    REQUIRE(client.Delete("/v1/sites/" + first)->status == 204);
    CHECK(GetJson(client, PathOf(flight))["sites"].dump().find(first) == std::string::npos);
  }
}

TEST_CASE("alternates: new, changed and superseded sites count at once, also of a silent flight") {
  const TemporaryFolder folder;
  Storage storage(StorageAt(folder.path()));
  MapCache maps({size_t{64} << 20, size_t{16} << 20});
  EventLog events;
  FlightRow row;
  row.id = std::string("x");
  row.request_json =
      ParseFlightRequest(R"({"name":"x","altitude_datum":"amsl","aircraft":{"profile":"small"}})")
          .canonical_json;
  storage.flights.Insert(row);
  storage.telemetry.Put("x", ParseTelemetryLine(LineAt(1700000000000000, 900.0)));
  Alternates alternates(storage, maps, events, 3);
  const auto ids = [&] {
    std::vector<std::string> found;
    const nlohmann::json answer = nlohmann::json::parse(alternates.Answer("x"));
    for (const auto& site : answer["sites"]) found.push_back(site["site_id"]);
    return found;
  };
  CHECK(ids().empty());
  StoreAmslMeadow(storage);
  CHECK(ids() == std::vector<std::string>{"f-r1"});
  SiteRow newer = MeadowSite("amsl");
  newer.id = std::string("g-r1");
  Standing superseded;
  superseded.superseded_by = std::string("g-r1");
  PutOnMap(storage, newer, Meadow(), {{"f-r1", superseded}});
  CHECK(ids() == std::vector<std::string>{"g-r1"});
  Standing free;
  storage.sites.Delete("g-r1", {{"f-r1", free}});
  CHECK(ids() == std::vector<std::string>{"f-r1"});
  storage.flights.Delete("x");
  alternates.Forget("x");
  CHECK(alternates.Answer("x").empty());
}

TEST_CASE("alternates: photographs of a batch tell the pose too") {
  FreshServer fresh;
  const std::string flight = NewSampleFlight(fresh.client);
  CHECK(HasWarning(GetJson(fresh.client, PathOf(flight)), "no pose"));
  PostSampleFrames(fresh.client, flight, 0, 3);
  CHECK(Becomes(fresh.client, flight, std::chrono::seconds(2), [](const nlohmann::json& answer) {
    return answer.contains("pose") && answer["pose"]["age_s"].is_number();
  }));
}

}  // namespace
}  // namespace freelsd
