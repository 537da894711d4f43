// The feed over HTTP, and a server that follows another one.
#include <algorithm>
#include <chrono>
#include <functional>
#include <thread>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "tests/server/following/simulated_flight.h"
#include "tests/server/test_server.h"

namespace freelsd {
namespace {

constexpr int64_t kSeenUs = 1600000000000000;
constexpr char kMast[] =
    R"({"type":"Feature","geometry":{"type":"Point","coordinates":[8.0,47.004]},)"
    R"("properties":{"kind":"mast","height_m":30}})";
constexpr char kFarMast[] =
    R"({"type":"Feature","geometry":{"type":"Point","coordinates":[20.0,47.0]},)"
    R"("properties":{"kind":"mast","height_m":30}})";
constexpr char kArea[] = "7,46,9,48";

void Send(httplib::Client& client, const SimulatedFlight& flight) {
  const ToldFlight told = Fly(flight);
  for (const auto& [id, bytes] : told.map_bytes) {
    const httplib::Result put = client.Put("/v1/maps/" + id, bytes, "application/octet-stream");
    REQUIRE(put);
    REQUIRE(put->status == 201);
  }
  nlohmann::json body{{"changes", nlohmann::json::array()}};
  for (const ToldChange& change : told.changes) {
    body["changes"].push_back(ToldJson(change, "aircraft"));
  }
  const httplib::Result posted = client.Post("/v1/changes", body.dump(), "application/json");
  REQUIRE(posted);
  REQUIRE(posted->status == 200);
}

void PutMast(httplib::Client& client, const std::string& id, const char* mast = kMast) {
  const httplib::Result put = client.Put("/v1/obstacles/" + id, mast, "application/geo+json");
  REQUIRE(put);
  REQUIRE(put->status == 201);
}

std::vector<std::string> IdsIn(const nlohmann::json& page) {
  std::vector<std::string> ids;
  for (const nlohmann::json& change : page["changes"]) {
    ids.push_back(change["id"].get<std::string>() + " " + change["change"].get<std::string>());
  }
  return ids;
}

using Ids = std::vector<std::string>;

// Within half a minute.
bool Becomes(const std::function<bool()>& is_so) {
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  while (!is_so()) {
    if (std::chrono::steady_clock::now() > until) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  return true;
}

TEST_CASE("changes over HTTP: what is stored is told page by page, and what is removed") {
  FreshServer fresh;
  Send(fresh.client, {.id = "a", .seen_at_us = kSeenUs});
  PutMast(fresh.client, "mast");
  const nlohmann::json first = GetJson(fresh.client, "/v1/changes?limit=2");
  CHECK(IdsIn(first) == Ids{"a/1 stored", "a-r1 stored"});
  CHECK(first["has_more"] == true);
  const std::string next = first["next"];
  const nlohmann::json second = GetJson(fresh.client, "/v1/changes?since=" + next);
  CHECK(IdsIn(second) == Ids{"mast stored"});
  CHECK(second["has_more"] == false);
  const std::string last = second["next"];
  REQUIRE(fresh.client.Delete("/v1/obstacles/mast")->status == 204);
  REQUIRE(fresh.client.Delete("/v1/sites/a-r1")->status == 204);
  CHECK(IdsIn(GetJson(fresh.client, "/v1/changes?since=" + last)) ==
        Ids{"mast removed", "a-r1 removed"});
  // A new follower needs no removals.
  CHECK(IdsIn(GetJson(fresh.client, "/v1/changes")) == Ids{"a/1 stored"});
}

TEST_CASE("changes over HTTP: a box has its sites, what is around them, and what has left") {
  FreshServer fresh;
  Send(fresh.client, {.id = "a", .seen_at_us = kSeenUs});
  Send(fresh.client, {.id = "b", .longitude_deg = 12.0, .seen_at_us = kSeenUs});
  PutMast(fresh.client, "mast");
  const std::string box = "&bbox=7.99,46.98,8.01,47.01";
  const nlohmann::json page = GetJson(fresh.client, "/v1/changes?since=0" + box);
  CHECK(IdsIn(page) == Ids{"a/1 stored", "a-r1 stored", "mast stored"});
  const httplib::Result put =
      fresh.client.Put("/v1/obstacles/mast", kFarMast, "application/geo+json");
  REQUIRE(put->status == 200);
  const std::string next = page["next"];
  CHECK(IdsIn(GetJson(fresh.client, "/v1/changes?since=" + next + box)) == Ids{"mast left"});
}

TEST_CASE("changes over HTTP: a follower of another feed, or from the future, begins anew") {
  FreshServer fresh;
  const std::string feed = GetJson(fresh.client, "/v1/changes")["feed"];
  for (const std::string& since : {std::string("other-0-0"), feed + "-7-7"}) {
    const nlohmann::json page = GetJson(fresh.client, "/v1/changes?since=" + since);
    CHECK(page["begin_anew"] == "other_feed");
    CHECK(page["changes"].empty());
  }
  CheckProblem(fresh.client.Get("/v1/changes?since=yesterday"), 400, "InvalidQuery");
  CheckProblem(fresh.client.Get("/v1/changes?limit=0"), 422, "InvalidValue");
  CheckProblem(fresh.client.Get("/v1/changes?wait_s=31"), 422, "InvalidValue");
}

TEST_CASE("changes over HTTP: a client waits for news, and gets them at once") {
  FreshServer fresh;
  const std::string next = GetJson(fresh.client, "/v1/changes")["next"];
  std::thread later([&fresh] {
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    httplib::Client other = fresh.server.Client();
    PutMast(other, "mast");
  });
  const auto begin = std::chrono::steady_clock::now();
  const nlohmann::json page = GetJson(fresh.client, "/v1/changes?wait_s=20&since=" + next);
  later.join();
  CHECK(IdsIn(page) == Ids{"mast stored"});
  CHECK(std::chrono::steady_clock::now() - begin < std::chrono::seconds(15));
}

TEST_CASE("changes over HTTP: what is wrong is refused by its place, and changes nothing") {
  FreshServer fresh;
  const auto post = [&fresh](const std::string& body) {
    return fresh.client.Post("/v1/changes", body, "application/json");
  };
  CheckProblem(post("{}"), 422, "InvalidValue");
  CheckProblem(post(R"({"changes":[{"subject":"ufo","id":"a","change":"stored","origin":"b"}]})"),
               422,
               "InvalidValue");
  const ToldFlight flight = Fly({.id = "a", .seen_at_us = kSeenUs});
  const nlohmann::json whole = ToldJson(flight.changes[1], "aircraft");
  const auto with = [&whole](const std::string& pointer, const nlohmann::json& value) {
    nlohmann::json changed = whole;
    changed[nlohmann::json::json_pointer(pointer)] = value;
    return nlohmann::json{{"changes", {changed}}}.dump();
  };
  for (const auto& [pointer, value] : std::vector<std::pair<std::string, nlohmann::json>>{
           {"/site/latitude_deg", "north"},
           {"/site/longitude_deg", 200.0},
           {"/site/feature/properties/verdict", "rejected"},
           {"/site/recall/is_landable", 1},
           {"/site/replan", nlohmann::json::object()},
           {"/site/standing", nullptr},
           {"/site/map_box", {1, 2, 3}}}) {
    const std::string place = pointer;
    CAPTURE(place);
    const httplib::Result result = post(with(pointer, value));
    CheckProblem(result, 422, "InvalidValue");
    CHECK(result->body.find("/changes/0/site") != std::string::npos);
  }
  CheckProblem(post(nlohmann::json{{"changes", {whole}}}.dump()), 409, "MapMissing");
  CheckProblem(
      fresh.client.Put("/v1/maps/a/1", "no map", "application/octet-stream"), 422, "InvalidValue");
  CheckProblem(fresh.client.Get("/v1/maps/a/1"), 404, "NoMap");
  CHECK(GetJson(fresh.client, "/v1/changes")["changes"].empty());
}

Config Following(Config config, int port) {
  config.follow = "http://127.0.0.1:" + std::to_string(port);
  config.area = kArea;
  return config;
}

std::string FeedOf(httplib::Client& client) {
  nlohmann::json all = nlohmann::json::object();
  const nlohmann::json page = GetJson(client, "/v1/changes?limit=1000");
  for (nlohmann::json change : page["changes"]) {
    const std::string key = change["subject"].get<std::string>() + change["id"].get<std::string>();
    change.erase("number");
    change.erase("change");
    all[key] = change;
  }
  return all.dump();
}

TEST_CASE("following: both sides come in step, also after a start, and recall tells the age") {
  FreshServer centre;
  const TemporaryFolder folder;
  const Config config = Following(TestConfig(folder.path()), centre.server.port());
  Send(centre.client, {.id = "a", .seen_at_us = kSeenUs});
  PutMast(centre.client, "mast");
  {
    TestServer edge(config);
    httplib::Client client = edge.Client();
    CHECK(Becomes([&] { return FeedOf(client) == FeedOf(centre.client); }));
    Send(client,
         {.id = "wall",
          .seen_at_us = kSeenUs + 1000000,
          .field = FieldState::kWalled,
          .has_site = false});
    PutMast(client, "other-mast");
    CHECK(Becomes([&] {
      const auto site = GetJson(centre.client, "/v1/changes").dump();
      return site.find("wall/1") != std::string::npos && FeedOf(client) == FeedOf(centre.client);
    }));
    CHECK(FeedOf(centre.client).find(R"("superseded_by":"wall")") != std::string::npos);
    CHECK(Becomes([&] { return GetJson(client, "/healthz")["copy"].contains("age_s"); }));
    const nlohmann::json answer =
        GetJson(client, "/v1/emergency?latitude_deg=46.99&longitude_deg=8&altitude_m=1100");
    CHECK(answer["copy"]["of"] == config.follow);
    CHECK(answer["copy"]["age_s"] >= 0.0);
    CHECK(answer["warnings"].dump().find("answered from a copy") != std::string::npos);
  }
  REQUIRE(centre.client.Delete("/v1/obstacles/mast")->status == 204);
  Send(centre.client, {.id = "b", .longitude_deg = 8.1, .seen_at_us = kSeenUs});
  TestServer edge(config);
  httplib::Client client = edge.Client();
  CHECK(Becomes([&] { return FeedOf(client) == FeedOf(centre.client); }));
  CHECK(GetJson(client, "/v1/obstacles")["features"].size() == 1);
}

TEST_CASE("following: a centre with another database gets what an edge has made") {
  const TemporaryFolder folder;
  auto centre = std::make_unique<FreshServer>();
  const int port = centre->server.port();
  TestServer edge(Following(TestConfig(folder.path()), port));
  httplib::Client client = edge.Client();
  Send(centre->client, {.id = "told", .longitude_deg = 8.1, .seen_at_us = kSeenUs});
  PutMast(client, "own-mast");
  PutMast(centre->client, "centre-mast");
  CHECK(Becomes([&] {
    const std::string feed = FeedOf(client);
    return feed.find("centre-mast") != std::string::npos && feed == FeedOf(centre->client);
  }));
  centre = nullptr;
  const FreshServer other([port](Config& config) { config.port = port; });
  httplib::Client other_client = other.server.Client();
  CHECK(Becomes([&] { return FeedOf(other_client).find("own-mast") != std::string::npos; }));
  CHECK(Becomes([&] { return FeedOf(other_client).find("told-r1") != std::string::npos; }));
  // What the centre itself had made is told by nobody any more.
  CHECK(Becomes([&] { return FeedOf(client).find("centre-mast") == std::string::npos; }));
  CHECK(GetJson(client, "/v1/obstacles")["features"].size() == 1);
}

TEST_CASE("following: a centre is left for another one, and followed again") {
  const TemporaryFolder folder;
  FreshServer first, second;
  PutMast(first.client, "mast-of-first");
  PutMast(second.client, "mast-of-second");
  const auto follow = [&folder](FreshServer& centre, const Ids& names) {
    TestServer edge(Following(TestConfig(folder.path()), centre.server.port()));
    httplib::Client client = edge.Client();
    if (names.size() == 1) PutMast(client, "own-mast");
    const auto has_all = [&names](const std::string& feed) {
      return std::all_of(names.begin(), names.end(), [&feed](const std::string& name) {
        return feed.find(name) != std::string::npos;
      });
    };
    CHECK(Becomes([&] {
      const std::string feed = FeedOf(client);
      return feed == FeedOf(centre.client) && has_all(feed);
    }));
    CHECK(Becomes([&] { return GetJson(client, "/healthz")["copy"]["num_unsent"] == 0; }));
    CHECK(GetJson(client, "/v1/obstacles")["features"].size() == 2);
  };
  follow(first, {"mast-of-first"});
  follow(second, {"mast-of-second", "own-mast"});
  follow(first, {"mast-of-first", "own-mast"});
}

TEST_CASE("following: settings that cannot be are refused") {
  const TemporaryFolder folder;
  const auto start = [&folder](const std::function<void(Config&)>& change) {
    Config config = TestConfig(folder.path());
    config.follow = "http://127.0.0.1:1";
    config.area = kArea;
    change(config);
    const App app(config);
  };
  CHECK_THROWS_AS(start([](Config& config) { config.area = "1,2,3"; }), ConfigError);
  CHECK_THROWS_AS(start([](Config& config) { config.follow_token_file = "/nowhere"; }),
                  ConfigError);
}

}  // namespace
}  // namespace freelsd
