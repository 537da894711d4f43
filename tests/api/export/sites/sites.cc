#include "tests/api/export/sites/sites.h"

#include <cmath>
#include <random>

#include <GeographicLib/Geodesic.hpp>
#include <nlohmann/json.hpp>

namespace freelsd {
namespace {

Approach MakeApproach(const KnownSiteOptions& options) {
  const Eigen::Vector2d ahead = DirectionOf(options.heading);
  const Eigen::Vector2d right(ahead.y(), -ahead.x());
  Approach approach;
  approach.heading = options.heading;
  approach.approach_distance = 108.58;
  approach.approach_height = 12.0;
  approach.loiter_radius = 178.9;
  approach.loiter_direction = options.direction;
  approach.min_clearance = 2.25;
  approach.touchdown_in_world = options.touchdown_in_world;
  approach.approach_start_in_world = options.touchdown_in_world;
  approach.approach_start_in_world.head<2>() -= ahead * approach.approach_distance;
  approach.approach_start_in_world.z() += approach.approach_height;
  approach.loiter_center_in_world = approach.approach_start_in_world;
  approach.loiter_center_in_world.head<2>() +=
      right * approach.loiter_radius * (options.direction == LoiterDirection::kRight ? 1.0 : -1.0);
  const double z = options.touchdown_in_world.z();
  const double unseen = std::nan("");
  approach.profile = {{108.58, 80.0, 50.0, 20.0, 0.0},
                      {z + 12, z + 8.8, z + 5.5, z + 2.2, z},
                      {z, unseen, z + 2, z, z}};
  if (options.verdict == Verdict::kRejected) return approach;
  // Climbs by 5 degrees for 200 m.
  GoAround go_around{.no_return_distance = 40.0, .unseen_ratio = 0.25};
  go_around.start_in_world = options.touchdown_in_world;
  go_around.start_in_world.head<2>() -= ahead * go_around.no_return_distance;
  go_around.start_in_world.z() += 40.0 * approach.approach_height / approach.approach_distance;
  go_around.climb_angle = RadFromDeg(5.0);
  go_around.end_in_world = go_around.start_in_world;
  go_around.end_in_world.head<2>() += ahead * 200.0;
  go_around.end_in_world.z() += 200.0 * std::tan(go_around.climb_angle);
  approach.go_around = go_around;
  return approach;
}

}  // namespace

KnownSite MakeSite(const KnownSiteOptions& options) {
  const LocalFrame frame(options.origin);
  Site site;
  site.region.id = options.region_id;
  site.region.num_observations = 10;
  site.region.grade = 0.9;
  site.region.area_m2 = 4000;
  site.wind = WindEstimate{{-2.0, 1.0}, 0.1, 3, 0};
  site.plan.verdict = options.verdict;
  if (options.verdict == Verdict::kRejected) {
    site.plan.reject_reason = RejectReason::kApproachBlocked;
    site.plan.reject_detail = "a <tree> & \"wire\" stand in it";
  }
  site.plan.touchdown_in_world = options.touchdown_in_world;
  site.plan.hazard_distance = 21.0;
  site.plan.score = 0.6;
  site.plan.approach = MakeApproach(options);
  const FlightContext context{"f1", options.altitude_datum, frame};
  nlohmann::json feature = SiteFeature("f1-r" + std::to_string(options.region_id),
                                       site,
                                       Aircraft{},
                                       "2026-01-01T00:00:00Z",
                                       context);
  feature["properties"]["rank"] = 1;
  const Approach& approach = *site.plan.approach;
  KnownSite known;
  known.feature_json = feature.dump();
  known.approach_json = ApproachJson(site.plan, context).dump();
  known.stored = ReadStoredSite(known.feature_json, known.approach_json, options.altitude_datum);
  known.touchdown = frame.GeoFromWorld(approach.touchdown_in_world);
  known.start = frame.GeoFromWorld(approach.approach_start_in_world);
  known.loiter_center = frame.GeoFromWorld(approach.loiter_center_in_world);
  known.loiter_radius_m = approach.loiter_radius;
  known.distance_m = approach.approach_distance;
  known.is_right_turn = options.direction == LoiterDirection::kRight;
  double azimuth_at_start;
  GeographicLib::Geodesic::WGS84().Inverse(known.start.latitude_deg,
                                           known.start.longitude_deg,
                                           known.touchdown.latitude_deg,
                                           known.touchdown.longitude_deg,
                                           azimuth_at_start,
                                           known.heading_deg);
  return known;
}

KnownSiteOptions SomewhereOnEarth(int index) {
  std::mt19937 random(static_cast<unsigned>(index) + 1);
  const auto between = [&random](double low, double high) {
    return low + (high - low) * (random() / 4294967296.0);
  };
  KnownSiteOptions options;
  options.origin = {between(-80.0, 80.0), between(-180.0, 180.0), between(-100.0, 3000.0)};
  // Every fourth one: within a few hundred metres of the antimeridian.
  if (index % 4 == 0) options.origin.longitude_deg = index % 8 == 0 ? 179.9999 : -179.9999;
  options.touchdown_in_world = {
      between(-1500.0, 1500.0), between(-1500.0, 1500.0), between(-20.0, 40.0)};
  options.heading = between(0.0, 2.0 * kPi);
  options.direction = index % 2 == 0 ? LoiterDirection::kLeft : LoiterDirection::kRight;
  return options;
}

}  // namespace freelsd
