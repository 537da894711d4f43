// The ground in reach over HTTP.
#include <chrono>
#include <cmath>
#include <limits>
#include <memory>
#include <thread>

#include <doctest/doctest.h>

#include "tests/server/meadow.h"
#include "tests/server/recall/emergency_query.h"
#include "tests/server/site_on_map.h"

namespace freelsd {
namespace {

// 200 m above the meadow's middle, flying north in still air.
std::string ReachQuery(double altitude_m, const std::string& more = kCalmNorth) {
  return "/v1/reach?latitude_deg=47.0&longitude_deg=8.0&altitude_m=" + std::to_string(altitude_m) +
         more;
}

std::vector<nlohmann::json> OfKind(const nlohmann::json& answer, const std::string& kind) {
  std::vector<nlohmann::json> features;
  for (const nlohmann::json& feature : answer["features"]) {
    if (feature["properties"]["kind"] == kind) features.push_back(feature);
  }
  return features;
}

Polygon PolygonOf(const nlohmann::json& ring) {
  Polygon polygon;
  const LocalFrame local_frame({47.0, 8.0, 0.0});
  for (size_t i = 0; i + 1 < ring.size(); ++i) {
    polygon.push_back(local_frame.WorldFromGeo({ring[i][1], ring[i][0], 0.0}).head<2>());
  }
  return polygon;
}

bool IsInRings(const nlohmann::json& rings, const Eigen::Vector2d& place) {
  if (!Contains(PolygonOf(rings[0]), place)) return false;
  for (size_t i = 1; i < rings.size(); ++i) {
    if (Contains(PolygonOf(rings[i]), place)) return false;
  }
  return true;
}

// Whether a place, east and north of the meadow's middle in metres, is in a feature of this kind.
bool IsIn(const nlohmann::json& answer, const std::string& kind, const Eigen::Vector2d& place) {
  for (const nlohmann::json& feature : OfKind(answer, kind)) {
    const nlohmann::json& geometry = feature["geometry"];
    const bool is_one = geometry["type"] == "Polygon";
    const nlohmann::json polygons =
        is_one ? nlohmann::json::array({geometry["coordinates"]}) : geometry["coordinates"];
    for (const nlohmann::json& rings : polygons) {
      if (IsInRings(rings, place)) return true;
    }
  }
  return false;
}

// Another site's map over the same ground as the meadow, never recalled.
void StoreMap(Storage& storage, const SiteMap& map, double north_m = 0.0) {
  SiteRow row = MeadowSite("amsl", north_m);
  row.id = std::string("f-r9");
  row.recall.reset();
  row.map_datum = "amsl";
  PutOnMap(storage, row, map);
}

TEST_CASE("reach: over the meadow the ground is in reach, around it the terrain is unknown") {
  const MeadowServer meadow(StoreAmslMeadow);
  const nlohmann::json answer = GetJson(*meadow.client, ReachQuery(600.0));
  CHECK(answer["type"] == "FeatureCollection");
  CHECK(answer["altitude_datum"] == "amsl");
  CHECK(answer["num_maps"] == 1);
  CHECK(answer["assumed_ground_altitude_m"].get<double>() == doctest::Approx(400.1).epsilon(1e-4));
  REQUIRE(OfKind(answer, "reach").size() == 1);
  REQUIRE(OfKind(answer, "unknown_terrain").size() == 1);
  const nlohmann::json reach = OfKind(answer, "reach")[0];
  CHECK(reach["geometry"]["type"] == "Polygon");
  // The map is 600 m wide.
  CHECK(reach["properties"]["area_m2"].get<double>() == doctest::Approx(360000.0).epsilon(0.05));
  for (const double east : {-290.0, 0.0, 290.0}) {
    for (const double north : {-290.0, 0.0, 290.0}) {
      CHECK(IsIn(answer, "reach", {east, north}));
      CHECK_FALSE(IsIn(answer, "unknown_terrain", {east, north}));
    }
  }
  // 190 m of height at a glide ratio of 7.
  for (const Eigen::Vector2d& place : {Eigen::Vector2d(0.0, 1300.0), Eigen::Vector2d(500.0, 0.0)}) {
    CHECK(IsIn(answer, "unknown_terrain", place));
    CHECK_FALSE(IsIn(answer, "reach", place));
  }
  CHECK_FALSE(IsIn(answer, "unknown_terrain", {0.0, 1331.0}));
}

TEST_CASE("reach: rings are closed, the outer one counter-clockwise and holes clockwise") {
  const MeadowServer meadow(StoreAmslMeadow);
  const nlohmann::json answer = GetJson(*meadow.client, ReachQuery(600.0));
  const nlohmann::json rings = OfKind(answer, "unknown_terrain")[0]["geometry"]["coordinates"];
  REQUIRE(rings.size() == 2);
  for (const nlohmann::json& ring : rings) CHECK(ring.front() == ring.back());
  CHECK(SignedArea(PolygonOf(rings[0])) > 0.0);
  CHECK(SignedArea(PolygonOf(rings[1])) < 0.0);
}

TEST_CASE("reach: a hill on a stored map hides what lies behind it") {
  const MeadowServer meadow([](Storage& storage) {
    StoreAmslMeadow(storage);
    SiteMap wall = Meadow();
    // 100 m north of the middle, 300 m wide, 190 m high.
    wall.map.upper(cv::Rect(150, 195, 300, 5)) = 190.0f;
    StoreMap(storage, wall);
  });
  const nlohmann::json answer = GetJson(*meadow.client, ReachQuery(600.0));
  CHECK(IsIn(answer, "reach", {0.0, 80.0}));
  CHECK_FALSE(IsIn(answer, "reach", {0.0, 102.0}));
  CHECK_FALSE(IsIn(answer, "reach", {0.0, 250.0}));
  CHECK_FALSE(IsIn(answer, "unknown_terrain", {0.0, 600.0}));
  CHECK(IsIn(answer, "reach", {0.0, -250.0}));
}

TEST_CASE("reach: unseen cells of a map are unknown terrain unless another map sees them") {
  SiteMap holed = Meadow();
  for (cv::Mat1f* const layer : {&holed.map.elevation, &holed.map.upper, &holed.map.num_points}) {
    (*layer)(cv::Rect(280, 400, 40, 40)) = std::numeric_limits<float>::quiet_NaN();
  }
  const Eigen::Vector2d in_hole(0.0, -120.0);
  const MeadowServer alone([&](Storage& storage) { PutOnMap(storage, MeadowSite("amsl"), holed); });
  const nlohmann::json answer = GetJson(*alone.client, ReachQuery(600.0));
  CHECK_FALSE(IsIn(answer, "reach", in_hole));
  CHECK(IsIn(answer, "unknown_terrain", in_hole));
  CHECK(IsIn(answer, "reach", {40.0, -120.0}));
  const MeadowServer both([&](Storage& storage) {
    PutOnMap(storage, MeadowSite("amsl"), holed);
    StoreMap(storage, Meadow());
  });
  CHECK(IsIn(GetJson(*both.client, ReachQuery(600.0)), "reach", in_hole));
}

nlohmann::json PositionAt(double east_m, double north_m) {
  const GeoPoint place = LocalFrame({47.0, 8.0, 0.0}).GeoFromWorld({east_m, north_m, 0.0});
  return {place.longitude_deg, place.latitude_deg};
}

void PutObstacle(const MeadowServer& meadow,
                 const std::string& id,
                 const nlohmann::json& geometry,
                 const nlohmann::json& properties) {
  const nlohmann::json feature{
      {"type", "Feature"}, {"geometry", geometry}, {"properties", properties}};
  const auto result =
      meadow.client->Put("/v1/obstacles/" + id, feature.dump(), "application/geo+json");
  REQUIRE(result);
  INFO(result->body);
  REQUIRE(result->status == 201);
}

nlohmann::json SquareAt(double east_m, double north_m, double half_m) {
  nlohmann::json ring = nlohmann::json::array();
  for (const auto& [x, y] : {std::pair(-1, -1), {1, -1}, {1, 1}, {-1, 1}, {-1, -1}}) {
    ring.push_back(PositionAt(east_m + x * half_m, north_m + y * half_m));
  }
  return {{"type", "Polygon"}, {"coordinates", nlohmann::json::array({ring})}};
}

TEST_CASE("reach: obstacles beyond the stored maps hide what lies behind them, airspaces nothing") {
  const MeadowServer meadow(StoreAmslMeadow);
  const Eigen::Vector2d behind_wire(0.0, 800.0), behind_mast(900.0, 0.0), beside_mast(900.0, 200.0);
  const Eigen::Vector2d on_people(0.0, -1200.0), in_airspace(-800.0, 0.0);
  const nlohmann::json before = GetJson(*meadow.client, ReachQuery(600.0));
  for (const auto& place : {behind_wire, behind_mast, beside_mast, on_people, in_airspace}) {
    CHECK(IsIn(before, "unknown_terrain", place));
  }
  // Half way to the ground there, on the way of all turns.
  PutObstacle(meadow,
              "wire",
              {{"type", "LineString"},
               {"coordinates",
                {{PositionAt(-600, 500)[0], PositionAt(-600, 500)[1], 560.0},
                 {PositionAt(600, 500)[0], PositionAt(600, 500)[1], 560.0}}}},
              {{"kind", "wire"}, {"altitude_datum", "amsl"}});
  // Its top's altitude is unknown.
  PutObstacle(meadow,
              "mast",
              {{"type", "Point"}, {"coordinates", PositionAt(600, 0)}},
              {{"kind", "mast"}, {"height_m", 150}});
  PutObstacle(meadow,
              "people",
              SquareAt(0, -1200, 20),
              {{"kind", "people"}, {"expires_at", "2100-01-01T00:00:00Z"}});
  PutObstacle(meadow, "airspace", SquareAt(-800, 0, 200), {{"kind", "no_fly"}});
  const nlohmann::json after = GetJson(*meadow.client, ReachQuery(600.0));
  CHECK_FALSE(IsIn(after, "unknown_terrain", behind_wire));
  CHECK(IsIn(after, "unknown_terrain", {0.0, 450.0}));
  CHECK_FALSE(IsIn(after, "unknown_terrain", behind_mast));
  CHECK(IsIn(after, "unknown_terrain", beside_mast));
  CHECK_FALSE(IsIn(after, "unknown_terrain", on_people));
  CHECK(IsIn(after, "unknown_terrain", {0.0, -1000.0}));
  CHECK(IsIn(after, "unknown_terrain", in_airspace));
}

// Neither wind nor heading, and ground everywhere that is too high to arrive at: most work.
constexpr char kWide[] = "&altitude_datum=amsl&arrival_height_m=300";

// Number of answers with this status, by the server's own count.
int NumAnswered(const MeadowServer& meadow, int status) {
  const std::string metrics = meadow.client->Get("/metrics")->body;
  const std::string key =
      R"(method="GET",route="/v1/reach",status=")" + std::to_string(status) + "\"} ";
  const size_t at = metrics.find(key);
  return at == std::string::npos ? 0 : std::stoi(metrics.substr(at + key.size()));
}

TEST_CASE("reach: a wide one is said to be coarser, and one in a known wind is not") {
  const MeadowServer meadow(StoreAmslMeadow);
  const nlohmann::json wide = GetJson(*meadow.client, ReachQuery(1200.0, kWide));
  const nlohmann::json narrow = GetJson(*meadow.client, ReachQuery(1200.0));
  CHECK(wide["cell_size_m"].get<double>() > narrow["cell_size_m"].get<double>());
  CHECK(wide["warnings"].dump().find("larger cells") != std::string::npos);
  CHECK(narrow["warnings"].dump().find("larger cells") == std::string::npos);
  // Right below, turns that no large cell is surely in leave a hole.
  CHECK(IsIn(wide, "reach", {0.0, 250.0}));
}

TEST_CASE(
    "reach: 40 wide ones: one is computed, four wait, the others are refused, /healthz answers") {
  constexpr int kNumGreedy = 40;
  constexpr int kNumTaken = 5;
  const MeadowServer meadow(StoreAmslMeadow);
  const std::string wide =
      "GET " + ReachQuery(1200.0, kWide) + " HTTP/1.1\r\nHost: localhost\r\n\r\n";
  std::vector<std::unique_ptr<RawConnection>> greedy;
  for (int i = 0; i < kNumGreedy; ++i) {
    greedy.push_back(std::make_unique<RawConnection>(meadow.server->port()));
    greedy.back()->Send(wide);
  }
  const auto await = [&](const std::vector<int>& statuses, int least) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(1);
    int num = 0;
    while (num < least && std::chrono::steady_clock::now() < end) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      num = 0;
      for (const int status : statuses) num += NumAnswered(meadow, status);
    }
    return num;
  };
  CHECK(await({429}, kNumGreedy / 2) >= kNumGreedy / 2);
  CHECK(meadow.client->Get("/healthz")->status == 200);
  // They leave: what is computed and what waits is given up.
  greedy.clear();
  CHECK(await({200, 429, 503}, kNumGreedy) == kNumGreedy);
  CHECK(NumAnswered(meadow, 200) + NumAnswered(meadow, 503) >= kNumTaken);
  CHECK(NumAnswered(meadow, 503) >= 1);
  CHECK(GetJson(*meadow.client, ReachQuery(600.0))["num_maps"] == 1);
}

TEST_CASE("reach: the sites and their margins are those of emergency") {
  const MeadowServer meadow(StoreAmslMeadow);
  for (const double altitude_m : {600.0, 425.0}) {
    const std::string more = std::to_string(altitude_m) + kCalmNorth + "&arrival_height_m=5";
    const std::string place = "latitude_deg=46.9955&longitude_deg=8.0&altitude_m=" + more;
    const nlohmann::json recalled = GetJson(*meadow.client, "/v1/emergency?" + place);
    const nlohmann::json reach = GetJson(*meadow.client, "/v1/reach?" + place);
    const std::vector<nlohmann::json> sites = OfKind(reach, "site");
    REQUIRE(sites.size() == 1);
    const nlohmann::json& site =
        recalled["sites"].empty() ? recalled["nearest_miss"] : recalled["sites"][0];
    for (const char* const key : {"site_id", "arrival_margin_m", "reachable", "time_s"}) {
      CHECK(sites[0]["properties"][key] == site[key]);
    }
    CHECK(sites[0]["geometry"]["coordinates"][1] == site["touchdown"]["latitude_deg"]);
    for (const nlohmann::json& warning : recalled["warnings"]) {
      CHECK(reach["warnings"].dump().find(warning.dump()) != std::string::npos);
    }
  }
}

TEST_CASE("reach: datums differ as they do for emergency") {
  const MeadowServer meadow(StoreAmslMeadow);
  const std::string ellipsoid =
      "&wind_east_mps=0&wind_north_mps=0&heading_deg=0&altitude_datum=ellipsoid";
  // The geoid lies about 48 m above the ellipsoid there.
  const nlohmann::json answer = GetJson(*meadow.client, ReachQuery(600.0, ellipsoid));
  CHECK(answer["assumed_ground_altitude_m"].get<double>() > 440.0);
  CHECK_FALSE(IsIn(answer, "unknown_terrain", {0.0, 1250.0}));
}

TEST_CASE("reach: without stored maps nearby there is no area, and no assumed ground") {
  const MeadowServer meadow(StoreAmslMeadow);
  const nlohmann::json answer =
      GetJson(*meadow.client, "/v1/reach?latitude_deg=-33&longitude_deg=179.9999&altitude_m=600");
  CHECK(answer["assumed_ground_altitude_m"].is_null());
  CHECK(OfKind(answer, "reach").empty());
  CHECK(OfKind(answer, "unknown_terrain").empty());
  CHECK(answer["warnings"].dump().find("no stored map is within gliding distance") !=
        std::string::npos);
}

TEST_CASE("reach: POST with the same JSON answers the same") {
  const MeadowServer meadow(StoreAmslMeadow);
  const nlohmann::json got = GetJson(*meadow.client, ReachQuery(600.0));
  const auto result = meadow.client->Post("/v1/reach",
                                          nlohmann::json{{"latitude_deg", 47.0},
                                                         {"longitude_deg", 8.0},
                                                         {"altitude_m", 600.0},
                                                         {"wind_east_mps", 0},
                                                         {"wind_north_mps", 0},
                                                         {"heading_deg", 0},
                                                         {"altitude_datum", "amsl"}}
                                              .dump(),
                                          "application/json");
  REQUIRE(result);
  REQUIRE(result->status == 200);
  CHECK(OfKind(nlohmann::json::parse(result->body), "reach") == OfKind(got, "reach"));
}

TEST_CASE("reach: bad parameters are named, with 400 or 422") {
  const MeadowServer meadow;
  httplib::Client& client = *meadow.client;
  CheckProblem(client.Get("/v1/reach?latitude_deg=47&longitude_deg=8"), 422, "InvalidValue");
  CheckProblem(client.Get(ReachQuery(500.0, "&f=plan")), 400, "UnknownParameter");
  CheckProblem(client.Get(ReachQuery(500.0, "&flight=nowhere")), 404, "NoSuchFlight");
  const auto result = client.Get(ReachQuery(500.0, "&arrival_height_m=-1"));
  CheckProblem(result, 422, "InvalidValue");
  CHECK(nlohmann::json::parse(result->body)["errors"][0]["pointer"] == "arrival_height_m");
  CheckProblem(client.Delete("/v1/reach"), 405, "MethodNotAllowed");
}

TEST_CASE("reach: a flight fills in its datum and aircraft") {
  const MeadowServer meadow(StoreAmslMeadow);
  const auto created = meadow.client->Post(
      "/v1/flights",
      R"({"name":"x","altitude_datum":"amsl","aircraft":{"profile":"techpod"}})",
      "application/json");
  REQUIRE(created);
  REQUIRE(created->status == 201);
  const std::string flight = nlohmann::json::parse(created->body)["id"];
  const nlohmann::json answer = GetJson(*meadow.client, ReachQuery(600.0, "&flight=" + flight));
  CHECK(answer["taken_from_flight"]["flight_id"] == flight);
  CHECK(answer["altitude_datum"] == "amsl");
  CHECK(answer["aircraft"]["profile"] == "techpod");
  // Else: the aircraft of the stored site.
  CHECK(GetJson(*meadow.client, ReachQuery(600.0))["aircraft"]["profile"] == "small");
}

}  // namespace
}  // namespace freelsd
