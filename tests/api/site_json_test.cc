#include <limits>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "api/api.h"
#include "tests/api/errors.h"

namespace freelsd {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kMaxPositionErrorDeg = 2e-9;
// A millimetre is what answers are rounded to; the earth's curve adds 1 mm in 110 m.
constexpr double kMaxAltitudeErrorM = 2e-3;

FlightContext Context() { return {"f1", "amsl", LocalFrame(GeoPoint{47.0, 8.0, 400.0})}; }

// Northbound final of 100 m from 12 m, left circle of 50 m radius (its centre is west).
Plan LandablePlan() {
  Plan plan;
  plan.verdict = Verdict::kLandable;
  plan.touchdown_in_world = {0, 0, 5};
  plan.hazard_distance = 24.5;
  plan.slope = 0.1;
  plan.roughness = 0.2;
  plan.score = 0.75;
  plan.score_terms = {{"hazard_distance", 0.9, 0.25}, {"slope", 0.1, 0.1}};
  Approach approach;
  approach.touchdown_in_world = plan.touchdown_in_world;
  approach.approach_start_in_world = {0, -100, 17};
  approach.heading = 0.0;
  approach.approach_distance = 100;
  approach.approach_height = 12;
  approach.loiter_radius = 50;
  approach.loiter_center_in_world = {-50, -100, 17};
  approach.loiter_direction = LoiterDirection::kLeft;
  approach.min_clearance = 2.25;
  approach.profile = {{100, 50, 0}, {17, 11, 5}, {6, kNaN, 5}};
  plan.approach = approach;
  return plan;
}

Site LandableSite() {
  Site site;
  site.region.id = 4;
  site.region.grade = 0.8;
  site.region.num_observations = 10;
  site.region.num_grass_observations = 8;
  site.region.area_m2 = 2500;
  // Clockwise on purpose.
  site.region.corners_in_world = {{0, 0, 5}, {0, 50, 5}, {50, 50, 5}, {50, 0, 5}};
  site.region.history = {{"a", 10, 1, 1, 0.0, 900}, {"b", 20, 2, 1, 0.5, 950}};
  site.wind = WindEstimate{{0, -5.5}, 0.1, 3, 0};
  site.plan = LandablePlan();
  return site;
}

nlohmann::json FeatureOf(const Site& site) {
  return SiteFeature("f1-4", site, Aircraft{}, "2026-01-01T00:00:00Z", Context());
}

TEST_CASE("site: every property of the contract is there") {
  const nlohmann::json feature = FeatureOf(LandableSite());
  const nlohmann::json& properties = feature["properties"];
  for (const char* const key : {"id",
                                "flight_id",
                                "region_id",
                                "score",
                                "verdict",
                                "unseen_ratio",
                                "grade",
                                "num_observations",
                                "num_grass_observations",
                                "area_m2",
                                "hazard_distance_m",
                                "slope_deg",
                                "roughness_m",
                                "elevation_m",
                                "wind",
                                "approach",
                                "updated_at",
                                "summary",
                                "rejections",
                                "score_terms",
                                "why",
                                "altitude_datum"}) {
    CAPTURE(std::string(key));
    CHECK(properties.contains(key));
  }
  CHECK(properties["verdict"] == "landable");
  CHECK_FALSE(properties.contains("reject_reason"));
  CHECK(properties["slope_deg"] == doctest::Approx(5.73));
  CHECK(properties["elevation_m"] == doctest::Approx(405.0));
  CHECK(properties["wind"]["north_mps"] == -5.5);
  CHECK(properties["approach"]["heading_deg"] == 0.0);
  CHECK(properties["approach"]["loiter_direction"] == "left");
  CHECK(properties["approach"]["min_clearance_m"] == 2.25);
  CHECK(feature["geometry"]["coordinates"][0] == doctest::Approx(8.0).epsilon(1e-12));
  CHECK(feature["geometry"]["coordinates"][1] == doctest::Approx(47.0).epsilon(1e-12));
}

TEST_CASE("wind rose: entries tell where their wind comes from, and no path where there is none") {
  WindRose rose{2, {3.0}, {LandablePlan(), Plan{}}};
  rose.plans[1].reject_reason = RejectReason::kWindTooStrong;
  const nlohmann::json object = WindRoseJson(rose, Context());
  CHECK(object["directions_deg"] == nlohmann::json{0.0, 180.0});
  CHECK(object["speeds_mps"] == nlohmann::json{3.0});
  CHECK(object["altitude_datum"] == "amsl");
  const nlohmann::json& north = object["entries"][0];
  CHECK(north["wind_from_deg"] == 0.0);
  CHECK(north["verdict"] == "landable");
  CHECK(north["reject_reason"].is_null());
  CHECK(north["heading_deg"] == 0.0);
  CHECK(north["min_clearance_m"] == 2.25);
  CHECK(north["touchdown"]["altitude_m"] == doctest::Approx(405.0));
  const nlohmann::json& south = object["entries"][1];
  CHECK(south["wind_from_deg"] == 180.0);
  CHECK(south["verdict"] == "rejected");
  CHECK(south["reject_reason"] == "wind_too_strong");
  for (const char* const key : {"touchdown", "heading_deg", "min_clearance_m", "unseen_ratio"}) {
    CHECK(south[key].is_null());
  }
}

TEST_CASE("site: wind from the side is told, and none where there is none") {
  Site site = LandableSite();
  CHECK(FeatureOf(site)["properties"]["approach"]["crosswind_mps"] == 0.0);
  CHECK(FeatureOf(site)["properties"]["summary"].get<std::string>().find("side") ==
        std::string::npos);
  site.plan.approach->crosswind = 1.26;
  const nlohmann::json properties = FeatureOf(site)["properties"];
  CHECK(properties["approach"]["crosswind_mps"] == 1.26);
  CHECK(properties["summary"].get<std::string>().find(
            "12 m up with 1.3 m/s of wind from the side") != std::string::npos);
}

TEST_CASE("site: what is unknown is null, never a number") {
  Site site = LandableSite();
  site.wind.reset();
  site.plan.slope = kNaN;
  site.plan.approach->min_clearance = kNaN;
  const nlohmann::json properties = FeatureOf(site)["properties"];
  CHECK(properties["wind"].is_null());
  CHECK(properties["slope_deg"].is_null());
  CHECK(properties["approach"]["min_clearance_m"].is_null());
}

TEST_CASE("site: where no terrain was seen no number is told") {
  Site site = LandableSite();
  site.plan = Plan{};
  site.plan.reject_reason = RejectReason::kNoTerrain;
  site.plan.reject_detail = "no cell of the region was seen";
  const nlohmann::json properties = FeatureOf(site)["properties"];
  CHECK(properties["verdict"] == "rejected");
  CHECK(properties["reject_reason"] == "no_terrain");
  CHECK(properties["summary"] == "Rejected (no_terrain): no cell of the region was seen.");
  for (const char* const key : {"hazard_distance_m",
                                "slope_deg",
                                "roughness_m",
                                "elevation_m",
                                "approach",
                                "unseen_ratio"}) {
    CAPTURE(std::string(key));
    CHECK(properties[key].is_null());
  }
}

TEST_CASE("site: rejections carry place, reason, and obstacle where there is one") {
  Site site = LandableSite();
  site.plan.rejections = {{{10, 0, 5}, RejectReason::kApproachBlocked, "tree", {{10, -30, 20}}},
                          {{0, 10, 5}, RejectReason::kLoiterBlocked, "hill", {}}};
  const nlohmann::json rejections = FeatureOf(site)["properties"]["rejections"];
  CHECK(rejections[0]["reason"] == "approach_blocked");
  CHECK(rejections[0]["touchdown"]["altitude_m"] == doctest::Approx(405.0));
  CHECK(rejections[0]["obstacle"]["altitude_m"] == doctest::Approx(420.0));
  CHECK_FALSE(rejections[1].contains("obstacle"));
}

TEST_CASE("site: ranked by verdict, then score, from 1") {
  const auto feature = [](const char* id, const char* verdict, double score) {
    return nlohmann::json{{"type", "Feature"},
                          {"properties", {{"id", id}, {"verdict", verdict}, {"score", score}}}};
  };
  const nlohmann::json ranked = RankedSites({feature("r", "rejected", 0.9),
                                             feature("u", "unverified", 0.95),
                                             feature("b", "landable", 0.2),
                                             feature("a", "landable", 0.2),
                                             feature("c", "landable", 0.6)});
  std::string order;
  for (const nlohmann::json& each : ranked["features"]) {
    order += each["properties"]["id"].get<std::string>() + ":" +
             std::to_string(each["properties"]["rank"].get<int>()) + " ";
  }
  CHECK(order == "c:1 a:2 b:3 u:4 r:5 ");
  CHECK(RankedSites({})["features"].is_array());
}

TEST_CASE("region: closed ring, counter-clockwise, and null for no wind") {
  const nlohmann::json feature = RegionFeature(LandableSite().region, std::nullopt, Context());
  const nlohmann::json ring = feature["geometry"]["coordinates"][0];
  REQUIRE(ring.size() == 5);
  CHECK(ring[0] == ring[4]);
  Polygon polygon;
  for (size_t i = 0; i < 4; ++i) polygon.emplace_back(ring[i][0], ring[i][1]);
  CHECK(SignedArea(polygon) > 0.0);
  CHECK(feature["properties"]["wind"].is_null());
  CHECK(feature["properties"]["id"] == 4);
}

TEST_CASE("region: history as in the paper's plots") {
  const nlohmann::json history = RegionHistoryJson(LandableSite().region)["history"];
  REQUIRE(history.size() == 2);
  CHECK(history[1]["grass_ratio"] == 0.5);
  CHECK(history[1]["frame_id"] == "b");
}

TEST_CASE("approach: straight final, closed circle flown left, touchdown, unseen ground is null") {
  const FlightContext context = Context();
  const nlohmann::json answer = ApproachJson(LandablePlan(), context);
  const nlohmann::json& line = answer["features"][0];
  CHECK(line["properties"]["kind"] == "approach");
  CHECK(line["geometry"]["coordinates"].size() == 2);
  const GeoPoint start = context.local_frame.GeoFromWorld({0, -100, 17});
  CHECK(std::abs(line["geometry"]["coordinates"][0][1].get<double>() - start.latitude_deg) <
        kMaxPositionErrorDeg);
  CHECK(std::abs(line["geometry"]["coordinates"][0][2].get<double>() - 417.0) < kMaxAltitudeErrorM);
  const nlohmann::json& circle = answer["features"][1]["geometry"]["coordinates"];
  CHECK(answer["features"][1]["properties"]["kind"] == "loiter");
  CHECK(circle.front() == circle.back());
  CHECK(circle.front() == line["geometry"]["coordinates"][0]);
  // Northbound with the centre in the west: after the start the aircraft goes on north, then west.
  CHECK(circle[1][1] > circle[0][1]);
  CHECK(circle[1][0] < circle[0][0]);
  CHECK(answer["features"][2]["properties"]["kind"] == "touchdown");
  const nlohmann::json& profile = answer["profile"];
  CHECK(profile["distance_m"] == nlohmann::json::array({100.0, 50.0, 0.0}));
  CHECK(profile["terrain_m"][1].is_null());
  CHECK(profile["clearance_m"][1].is_null());
  CHECK(profile["clearance_m"][0] == 11.0);
  CHECK(std::abs(profile["path_m"][2].get<double>() - 405.0) < kMaxAltitudeErrorM);
}

TEST_CASE("approach: a plan without one says so") {
  CHECK(ErrorOf([] { ApproachJson(Plan{}, Context()); }) == "409 NoApproach");
}

}  // namespace
}  // namespace freelsd
