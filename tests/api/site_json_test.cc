#include <limits>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "api/api.h"
#include "tests/api/errors.h"
#include "tests/api/plans.h"

namespace freelsd {
namespace {

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

TEST_CASE("site: wind from the side is told, and none where there is none") {
  Site site = LandableSite();
  CHECK(FeatureOf(site)["properties"]["approach"]["crosswind_mps"] == 0.0);
  CHECK(FeatureOf(site)["properties"]["summary"].get<std::string>().find("crosswind") ==
        std::string::npos);
  site.plan.approach->crosswind = 1.26;
  const nlohmann::json properties = FeatureOf(site)["properties"];
  CHECK(properties["approach"]["crosswind_mps"] == 1.26);
  CHECK(properties["summary"].get<std::string>().find(
            "12 m up with 1.3 m/s of crosswind on the final") != std::string::npos);
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

}  // namespace
}  // namespace freelsd
