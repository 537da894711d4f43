// What obstacles make of stored sites: of lists, of exports and of recall.
#include <algorithm>

#include <doctest/doctest.h>

#include "server/http/stamps.h"
#include "server/recall/obstacles/obstacles.h"
#include "tests/server/meadow.h"
#include "tests/server/openapi_check.h"
#include "tests/server/recall/emergency_query.h"
#include "tests/server/recall/flown_ground.h"
#include "tests/server/site_on_map.h"

namespace freelsd {
namespace {

constexpr int64_t kFirst = 1600000000000000;
// Away from the meadow that the server holds anyway. The field's plan lands northwards.
constexpr int kPlace = 1;

Flown Field() { return {.flight_id = "first", .seen_at_us = kFirst, .place = kPlace}; }

nlohmann::json PositionAt(double east_m, double north_m, const GeoPoint& origin) {
  const GeoPoint place = LocalFrame(origin).GeoFromWorld({east_m, north_m, 0.0});
  return {place.longitude_deg, place.latitude_deg};
}

nlohmann::json FeatureOf(const char* type,
                         const nlohmann::json& coordinates,
                         const nlohmann::json& properties) {
  return {{"type", "Feature"},
          {"geometry", {{"type", type}, {"coordinates", coordinates}}},
          {"properties", properties}};
}

// From west to east, so far north of the touchdown, of a height above ground.
nlohmann::json WireAcross(double north_m,
                          const GeoPoint& touchdown = TouchdownOf(kPlace),
                          double height_m = 15.0) {
  return FeatureOf("LineString",
                   {PositionAt(-400, north_m, touchdown), PositionAt(400, north_m, touchdown)},
                   {{"kind", "wire"}, {"height_m", height_m}, {"position_sd_m", 1}});
}

nlohmann::json SquareAround(const GeoPoint& middle,
                            double half_m,
                            const nlohmann::json& properties) {
  nlohmann::json ring = nlohmann::json::array();
  const std::vector<std::pair<int, int>> corners{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}, {-1, -1}};
  for (const auto& [x, y] : corners) ring.push_back(PositionAt(x * half_m, y * half_m, middle));
  nlohmann::json rings = nlohmann::json::array();
  rings.push_back(ring);
  return FeatureOf("Polygon", rings, properties);
}

struct FieldServer : MeadowServer {
  explicit FieldServer(const std::function<void(Storage&)>& more = {})
      : MeadowServer([&more](Storage& storage) {
          MapCache maps({size_t{1} << 24, size_t{1} << 22});
          Store(storage, maps, Field());
          if (more) more(storage);
        }) {
    HoldAgainstContract(*client);
  }

  void Put(const std::string& id, const nlohmann::json& feature) const {
    const auto result = client->Put("/v1/obstacles/" + id, feature.dump(), "application/geo+json");
    INFO(result->body);
    REQUIRE(result->status / 100 == 2);
  }
  void Delete(const std::string& id) const {
    REQUIRE(client->Delete("/v1/obstacles/" + id)->status == 204);
  }
  nlohmann::json Site() const { return GetJson(*client, "/v1/sites/first-r1")["properties"]; }
  std::string ListedVerdict() const {
    const nlohmann::json list = GetJson(*client, "/v1/sites?bbox=7.9,47.03,8.1,47.05");
    REQUIRE(list["features"].size() == 1);
    return list["features"][0]["properties"]["verdict"];
  }
  int StatusOf(const std::string& path) const { return client->Get(path)->status; }
  // In the wind of its own plan.
  bool IsRecalled() const {
    const nlohmann::json answer =
        GetJson(*client,
                "/v1/emergency?latitude_deg=47.035&longitude_deg=8&altitude_m=900&"
                "wind_east_mps=0&wind_north_mps=-4&heading_deg=0");
    return answer["sites"].dump().find("first-r1") != std::string::npos;
  }
};

TEST_CASE("obstructed: a wire across the stored final rejects the site until it is deleted") {
  const FieldServer field;
  REQUIRE(field.Site()["verdict"] == "landable");
  REQUIRE(field.IsRecalled());
  REQUIRE(field.StatusOf("/v1/sites/first-r1/approach") == 200);
  REQUIRE(field.StatusOf("/v1/sites/first-r1?f=kml") == 200);
  field.Put("line", WireAcross(-30.0));
  const nlohmann::json site = field.Site();
  INFO(site.dump());
  CHECK(site["verdict"] == "rejected");
  CHECK(site["reject_reason"] == "approach_blocked");
  CHECK(site["blocked_by"] == nlohmann::json{"line"});
  // Nothing of it reads like a good site.
  CHECK(site["score"] == 0.0);
  CHECK(site["failure_probability"].is_null());
  CHECK(site["hazard_distance_m"].is_null());
  CHECK(site["why"].get<std::string>().find("Ranked last: blocked by line") == 0);
  CHECK(field.ListedVerdict() == "rejected");
  CHECK_FALSE(field.IsRecalled());
  CHECK(field.StatusOf("/v1/sites/first-r1/approach") == 409);
  CHECK(field.StatusOf("/v1/sites/first-r1?f=cup") == 409);
  const std::string preload =
      field.client->Get("/v1/emergency/export?f=rally&home_altitude_m=300&bbox=7.9,47.03,8.1,47.05")
          ->body;
  CHECK(preload.find("field of first") == std::string::npos);
  const std::string area = "/v1/emergency/export?bbox=7.9,47.03,8.1,47.05";
  CHECK(GetJson(*field.client, area)["features"].empty());
  field.Delete("line");
  CHECK(GetJson(*field.client, area)["features"].size() == 1);
  CHECK(field.Site()["verdict"] == "landable");
  CHECK_FALSE(field.Site().contains("blocked_by"));
  CHECK(field.ListedVerdict() == "landable");
  CHECK(field.IsRecalled());
  CHECK(field.StatusOf("/v1/sites/first-r1/approach") == 200);
}

TEST_CASE("obstructed: obstacles beside the plan and airspaces reject nothing") {
  const FieldServer field;
  field.Put("aside", WireAcross(400.0));
  field.Put("zone", SquareAround(TouchdownOf(kPlace), 300.0, {{"kind", "no_fly"}}));
  CHECK(field.Site()["verdict"] == "landable");
  CHECK(field.IsRecalled());
}

TEST_CASE("obstructed: of several obstacles the one in the way is named") {
  const FieldServer field;
  field.Put("aside", WireAcross(150.0));
  field.Put("on-field",
            FeatureOf("Point",
                      PositionAt(0, 2, TouchdownOf(kPlace)),
                      {{"kind", "mast"}, {"height_m", 5}, {"position_sd_m", 0}}));
  const nlohmann::json site = field.Site();
  CHECK(site["verdict"] == "rejected");
  CHECK(site["reject_reason"] == "no_safe_touchdown");
  CHECK(site["blocked_by"] == nlohmann::json{"on-field"});
}

TEST_CASE("obstructed: a wire of a known altitude blocks by what it is above the map") {
  const FieldServer field;
  // The field lies at 400 m in an unknown datum. What is unsure counts as higher.
  nlohmann::json wire = WireAcross(-30.0);
  wire["properties"].erase("height_m");
  wire["properties"]["altitude_datum"] = "amsl";
  for (nlohmann::json& position : wire["geometry"]["coordinates"]) position.push_back(415.0);
  field.Put("line", wire);
  CHECK(field.Site()["verdict"] == "rejected");
}

TEST_CASE("obstructed: people count until they expire") {
  const FieldServer field;
  const std::string expires_at = Rfc3339(NowUs() + 3000000);
  field.Put("fair",
            SquareAround(TouchdownOf(kPlace),
                         20.0,
                         {{"kind", "people"}, {"expires_at", expires_at}, {"position_sd_m", 5}}));
  CHECK(field.Site()["verdict"] == "rejected");
  CHECK_FALSE(field.IsRecalled());
  std::this_thread::sleep_for(std::chrono::milliseconds(3500));
  CHECK(field.Site()["verdict"] == "landable");
  CHECK(field.IsRecalled());
}

TEST_CASE("obstructed: what obstacles block is not superseded: nothing of it is stored") {
  TemporaryFolder folder;
  Storage storage(StorageAt(folder.path()));
  MapCache maps({size_t{1} << 24, size_t{1} << 22});
  Store(storage, maps, Field());
  const nlohmann::json wire = WireAcross(-30.0);
  storage.obstacles.Put({{"line", wire.dump(), {7.99, 47.03, 8.01, 47.05}, std::nullopt, 1}}, 1);
  Flown later = Field();
  later.flight_id = "later";
  later.seen_at_us = kFirst + 86400000000;
  later.is_accepted = false;
  Store(storage, maps, later);
  const SiteRow site = *storage.sites.Find("first-r1");
  CHECK_FALSE(site.superseded_by);
  const auto obstruction = ObstructionOf({storage, maps}, site);
  REQUIRE(obstruction);
  CHECK(obstruction->obstacle_ids == std::vector<std::string>{"line"});
  CHECK(maps.Get(storage, "first-r1", site.updated_at_us)->obstacles.size() == 1);
  storage.obstacles.Delete("line");
  CHECK_FALSE(ObstructionOf({storage, maps}, site));
  CHECK(maps.Get(storage, "first-r1", site.updated_at_us)->obstacles.empty());
}

TEST_CASE("obstructed: recall plans around a mast on the field") {
  const MeadowServer meadow(StoreAmslMeadow);
  const auto put = [&meadow](const nlohmann::json& feature) {
    REQUIRE(meadow.client->Put("/v1/obstacles/o", feature.dump(), "application/geo+json")->status /
                100 ==
            2);
  };
  const GeoPoint middle{47.0, 8.0, 400.0};
  const nlohmann::json before = WholeAnswer(*meadow.client, Query(600.0, kCalmNorth));
  REQUIRE(before["sites"].size() == 1);
  const nlohmann::json& touchdown = before["sites"][0]["touchdown"];
  const GeoPoint place{touchdown["latitude_deg"], touchdown["longitude_deg"], 400.0};
  put(FeatureOf("Point",
                {place.longitude_deg, place.latitude_deg},
                {{"kind", "mast"}, {"height_m", 20}, {"position_sd_m", 0}}));
  const nlohmann::json around = WholeAnswer(*meadow.client, Query(600.0, kCalmNorth));
  REQUIRE(around["sites"].size() == 1);
  const nlohmann::json& other = around["sites"][0]["touchdown"];
  const Eigen::Vector3d moved =
      LocalFrame(place).WorldFromGeo({other["latitude_deg"], other["longitude_deg"], 400.0});
  // The disc of the small aircraft has a radius of 8 m.
  CHECK(moved.head<2>().norm() > 8.0);
  put(SquareAround(
      middle, 150.0, {{"kind", "people"}, {"expires_at", Rfc3339(NowUs() + 60000000)}}));
  CHECK(WholeAnswer(*meadow.client, Query(600.0, kCalmNorth))["sites"].empty());
}

TEST_CASE("obstructed: an airspace ranks a site last and never hides the only one") {
  const MeadowServer meadow([](Storage& storage) {
    StoreAmslMeadow(storage);
    SiteRow second = MeadowSite("amsl", 1500.0);
    second.id = std::string("f-r3");
    PutOnMap(storage, second, Meadow());
  });
  HoldAgainstContract(*meadow.client);
  const auto ids = [&meadow](double altitude_m) {
    std::vector<std::string> found;
    const nlohmann::json answer = WholeAnswer(*meadow.client, Query(altitude_m, kCalmNorth));
    for (const nlohmann::json& site : answer["sites"]) found.push_back(site["site_id"]);
    return found;
  };
  const std::vector<std::string> before = ids(1200.0);
  REQUIRE(before.size() == 2);
  const GeoPoint middle{before.front() == "f-r1" ? 47.0 : 47.0 + 1500.0 / 111195.0, 8.0, 400.0};
  const nlohmann::json zone = SquareAround(
      middle,
      400.0,
      {{"kind", "no_fly"}, {"ceiling_m", 480}, {"altitude_datum", "amsl"}, {"name", "zone"}});
  REQUIRE(meadow.client->Put("/v1/obstacles/zone", zone.dump(), "application/json")->status == 201);
  const std::vector<std::string> after = ids(1200.0);
  CHECK(after == std::vector<std::string>{before[1], before[0]});
  const nlohmann::json answer = WholeAnswer(*meadow.client, Query(1200.0, kCalmNorth));
  CHECK(answer["sites"][1]["airspaces"] == nlohmann::json{"zone"});
  CHECK(answer["sites"][1]["warnings"].dump().find("zone") != std::string::npos);
  CHECK_FALSE(answer["sites"][0].contains("airspaces"));
  // The best of one answer is that outside the airspace too.
  const nlohmann::json one =
      WholeAnswer(*meadow.client, Query(1200.0, std::string(kCalmNorth) + "&limit=1"));
  CHECK(one["sites"][0]["site_id"] == before[1]);
  // Over all of both: each is in it, and none is hidden.
  const nlohmann::json whole =
      SquareAround(middle, 5000.0, {{"kind", "no_fly"}, {"altitude_datum", "amsl"}});
  REQUIRE(meadow.client->Put("/v1/obstacles/zone", whole.dump(), "application/json")->status ==
          200);
  CHECK(ids(1200.0).size() == 2);
}

TEST_CASE("obstructed: heights of an airspace above ground count from the ground below the way") {
  // From 600 m, 200 m above the touchdown.
  const auto enters = [](const std::function<void(Storage&)>& store, const char* bound = "floor") {
    const MeadowServer meadow(store);
    HoldAgainstContract(*meadow.client);
    // The ceiling is that of a square on every way, at most 170 m above the touchdown.
    const bool is_floor = bound == std::string("floor");
    const GeoPoint middle{is_floor ? 47.0 : 46.9970, 8.0, 400.0};
    const nlohmann::json zone = SquareAround(
        middle,
        is_floor ? 5000.0 : 90.0,
        {{"kind", "no_fly"}, {bound + std::string("_above_ground_m"), is_floor ? 250 : 172}});
    REQUIRE(meadow.client->Put("/v1/obstacles/zone", zone.dump(), "application/json")->status ==
            201);
    const nlohmann::json answer = WholeAnswer(*meadow.client, Query(600.0, kCalmNorth));
    REQUIRE(answer["sites"].size() == 1);
    return answer["sites"][0].contains("airspaces");
  };
  const auto with_valley = [](Storage& storage) {
    StoreAmslMeadow(storage);
    MapCache maps({size_t{1} << 24, size_t{1} << 22});
    Flown valley{.flight_id = "valley", .is_accepted = false, .altitude_datum = "amsl"};
    valley.altitude_error_m = -150.0;
    valley.half_size_m = 130.0;
    valley.latitude_deg = 46.9967;
    Store(storage, maps, valley);
  };
  CHECK_FALSE(enters(StoreAmslMeadow));
  CHECK(enters(with_valley));
  // Two maps see the ground of the square, 150 m apart: the lower one alone puts the aircraft above
  // 172 m.
  CHECK(enters(with_valley, "ceiling"));
}

TEST_CASE("obstructed: a wire on the way, where no map is, counts by its altitude") {
  const MeadowServer meadow(StoreAmslMeadow);
  HoldAgainstContract(*meadow.client);
  // 400 m south of the touchdown; the map ends 300 m south of it.
  const GeoPoint middle{47.0, 8.0, 400.0};
  const auto margin_below = [&](double altitude_m) {
    nlohmann::json wire = WireAcross(-400.0, middle);
    wire["properties"] = {{"kind", "wire"}, {"altitude_datum", "amsl"}, {"position_sd_m", 2}};
    for (nlohmann::json& position : wire["geometry"]["coordinates"]) position.push_back(altitude_m);
    REQUIRE(meadow.client->Put("/v1/obstacles/line", wire.dump(), "application/json")->status /
                100 ==
            2);
    const nlohmann::json answer = WholeAnswer(*meadow.client, Query(600.0, kCalmNorth));
    const nlohmann::json& site =
        answer["sites"].empty() ? answer["nearest_miss"] : answer["sites"][0];
    INFO(answer.dump());
    CHECK(site["nearest_obstacle"] == "line");
    // The margin above the obstacle is that of the told path, which may be a longer one.
    const double margin_m = site["obstacle_margin_m"];
    CHECK((site["arrival_margin_m"].get<double>() >= 0.0) == (margin_m >= 0.0));
    return site["obstacle_margin_m"].get<double>();
  };
  const double low = margin_below(430.0);
  CHECK(low > 0.0);
  CHECK(margin_below(450.0) == doctest::Approx(low - 20.0).epsilon(0.01));
  // Higher than the aircraft: nobody passes below it.
  CHECK(margin_below(900.0) < 0.0);
  CHECK(GetJson(*meadow.client, Query(600.0, kCalmNorth))["sites"].empty());
}

TEST_CASE("obstructed: a wire on the way of which only the height is known is told") {
  const MeadowServer meadow(StoreAmslMeadow);
  const nlohmann::json wire = WireAcross(-400.0, {47.0, 8.0, 400.0});
  REQUIRE(meadow.client->Put("/v1/obstacles/line", wire.dump(), "application/json")->status == 201);
  const nlohmann::json answer = WholeAnswer(*meadow.client, Query(600.0, kCalmNorth));
  REQUIRE(answer["sites"].size() == 1);
  CHECK(answer["sites"][0]["warnings"].dump().find("crosses line") != std::string::npos);
}

TEST_CASE("obstructed: the alternates of a flight heed a new obstacle and its deletion") {
  const FieldServer field;
  const auto result = field.client->Post("/v1/flights", R"({"name":"live"})", "application/json");
  REQUIRE(result->status == 201);
  const std::string flight = nlohmann::json::parse(result->body)["id"];
  const std::string line = R"({"timestamp_us":)" + std::to_string(NowUs()) +
                           R"(,"position":{"latitude_deg":47.035,"longitude_deg":8.0,)"
                           R"("altitude_m":900},"wind":{"east_mps":0,"north_mps":-4}})";
  REQUIRE(field.client->Post("/v1/flights/" + flight + "/telemetry", line, "application/x-ndjson")
              ->status == 200);
  const auto has_field = [&] {
    return GetJson(*field.client, "/v1/flights/" + flight + "/alternates")["sites"].dump().find(
               "first-r1") != std::string::npos;
  };
  REQUIRE(has_field());
  field.Put("line", WireAcross(-30.0));
  CHECK_FALSE(has_field());
  field.Delete("line");
  CHECK(has_field());
}

}  // namespace
}  // namespace freelsd
