#include "server/recall/plan_check.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include "api/export/layers/layers.h"

namespace freelsd {
namespace {

// Margin on all sides of the plan, metres. It is larger than the widest corridor and disc of the
// known aircraft.
constexpr double kBoxMarginM = 200.0;

LoiterDirection TurnOf(const FinalPlaces& places) {
  return places.is_right_turn ? LoiterDirection::kRight : LoiterDirection::kLeft;
}

// The approach in the frame of another map. Heights are relative to the touchdown.
Approach ApproachIn(const LocalFrame& frame, const StoredPlan& plan) {
  const FinalPlaces& places = *plan.site.final_places;
  const auto at = [&frame](const GeoPoint& place, double height) {
    const GeoPoint level{place.latitude_deg, place.longitude_deg, frame.origin().altitude_m};
    const Eigen::Vector3d in_world = frame.WorldFromGeo(level);
    return Eigen::Vector3d(in_world.x(), in_world.y(), height);
  };
  Approach approach;
  approach.touchdown_in_world = at(plan.site.touchdown, 0.0);
  approach.approach_start_in_world = at(places.start, places.height_m);
  approach.loiter_center_in_world = at(places.loiter_center, places.height_m);
  const Eigen::Vector2d way =
      (approach.touchdown_in_world - approach.approach_start_in_world).head<2>();
  approach.heading = HeadingOf(way);
  approach.approach_distance = way.norm();
  approach.approach_height = places.height_m;
  approach.loiter_radius = places.loiter_radius_m;
  approach.loiter_direction = TurnOf(places);
  constexpr double kUnseen = std::numeric_limits<double>::quiet_NaN();
  const double ground_m = plan.site.touchdown.altitude_m;
  for (const ProfilePoint& point : plan.site.profile) {
    approach.profile.distance.push_back(point.distance_m);
    approach.profile.path_height.push_back(point.path_m.value_or(kUnseen) - ground_m);
    approach.profile.terrain_height.push_back(point.terrain_m.value_or(kUnseen) - ground_m);
  }
  return approach;
}

struct Reading {
  SiteMap site_map;
  ApproachOptions options;
};

// The map as the planner uses it: uncertain ground counts against the plan.
Reading Strict(const StoredPlan& plan, const SiteMap& site_map) {
  return {site_map, plan.replan.flight.options.approach};
}

// The map as if its position were exact and all its cells had a clear class. A less accurate map,
// or a map with unclear cells, does not prove that the ground has changed. A plan therefore fails
// only if it also breaks a rule on this reading.
Reading Lenient(const StoredPlan& plan, const SiteMap& site_map) {
  Reading reading = Strict(plan, site_map);
  reading.site_map.map.position_sd_m = 0.0;
  reading.site_map.map.tilt_sd_deg = 0.0;
  reading.site_map.layers.grass = site_map.layers.grass.clone();
  cv::patchNaNs(reading.site_map.layers.grass, 1.0);
  reading.options.min_map_position_sd_m = 0.0;
  reading.options.unclear_height_allowance_m = 0.0;
  return reading;
}

ApproachCheck CheckOn(const Reading& reading, const Approach& approach, const StoredPlan& plan) {
  const FlightRequest& flight = plan.replan.flight;
  const HazardLayers layers =
      WithLimits(reading.site_map.map,
                 reading.site_map.layers,
                 {flight.aircraft.max_slope_deg, flight.aircraft.max_roughness_m},
                 flight.options.hazard);
  return CheckApproach(approach,
                       reading.site_map.map,
                       layers,
                       flight.aircraft,
                       plan.replan.request.wind_in_world,
                       reading.options);
}

Polygon GroundOf(const StoredPlan& plan,
                 const Approach& approach,
                 const Grid& grid,
                 double position_sd_m) {
  ElevationMap extent;
  extent.grid = grid;
  extent.position_sd_m = std::isfinite(position_sd_m) ? position_sd_m : 0.0;
  const FlightRequest& flight = plan.replan.flight;
  return CheckedGround(approach,
                       extent,
                       flight.aircraft,
                       plan.replan.request.wind_in_world,
                       flight.options.approach);
}

// The part of the map that the check reads.
SiteMap CroppedTo(const StoredPlan& plan, const Approach& approach, const SiteMap& site_map) {
  const ElevationMap& map = site_map.map;
  return CropAround(
      map, site_map.layers, GroundOf(plan, approach, map.grid, map.position_sd_m), 0.0);
}

SiteMap With(const SiteMap& site_map, const std::vector<HardObstacle>& obstacles) {
  AssessedMap ground = WithObstacles(site_map.map, site_map.layers, obstacles, {});
  return {std::move(ground.map), std::move(ground.layers)};
}

// Of the circle, which may reach beyond the map.
std::optional<PlanCheck> BrokenBeyondMap(const StoredPlan& plan,
                                         const Approach& approach,
                                         const SiteMap& own_map,
                                         const std::vector<HardObstacle>& obstacles) {
  const LocalFrame frame(plan.replan.origin);
  Plan flown;
  flown.verdict = Verdict::kLandable;
  flown.approach = approach;
  // The heights of `approach` count from the touchdown.
  flown.approach->loiter_center_in_world.z() += frame.WorldFromGeo(plan.site.touchdown).z();
  flown =
      CheckedBeyondMap(std::move(flown), own_map.map, plan.replan.flight.aircraft, obstacles, {});
  if (flown.verdict != Verdict::kRejected) return std::nullopt;
  return PlanCheck{PlanVerdict::kFails, flown.reject_reason, flown.reject_detail};
}

bool IsSame(const std::optional<Rejection>& a, const std::optional<Rejection>& b) {
  return a.has_value() == b.has_value() &&
         (!a || (a->reason == b->reason && a->detail == b->detail));
}

std::optional<PlanCheck> FailureOf(const std::optional<Rejection>& broken) {
  if (!broken) return std::nullopt;
  return PlanCheck{PlanVerdict::kFails, broken->reason, broken->detail};
}

}  // namespace

std::optional<PlanCheck> BrokenByObstacles(const StoredPlan& plan,
                                           const SiteMap& own_map,
                                           const std::vector<HardObstacle>& obstacles) {
  if (obstacles.empty()) return std::nullopt;
  const Approach approach = ApproachIn(LocalFrame(plan.replan.origin), plan);
  const SiteMap around = CroppedTo(plan, approach, own_map);
  if (around.map.elevation.empty()) return std::nullopt;
  const SiteMap obstructed = With(around, obstacles);
  std::optional<Rejection> broken = CheckOn(Strict(plan, obstructed), approach, plan).rejection;
  // The stored numbers are rounded, so the check may refuse what the planner just accepted. This
  // refusal would hide what an obstacle breaks later on the way.
  if (broken && IsSame(broken, CheckOn(Strict(plan, around), approach, plan).rejection)) {
    broken = CheckOn(Lenient(plan, obstructed), approach, plan).rejection;
  }
  if (broken) return FailureOf(broken);
  return BrokenBeyondMap(plan, approach, around, obstacles);
}

std::optional<StoredPlan> ReadStoredPlan(const SiteRow& row) {
  if (row.approach_json.empty()) return std::nullopt;
  try {
    StoredPlan plan{ParseReplan(row.replan_json), {}};
    plan.site = ReadStoredSite(
        row.feature_json, row.approach_json, plan.replan.flight.altitude_datum.value_or("unknown"));
    if (plan.site.IsRejected() || !plan.site.final_places) return std::nullopt;
    return plan;
  } catch (const std::exception& error) {
    spdlog::error("site {} cannot be checked on later maps: {}", row.id, error.what());
    return std::nullopt;
  }
}

StoredPlan AsStoredPlan(const Plan& plan, Replan replan) {
  const LocalFrame frame(replan.origin);
  const Approach& approach = *plan.approach;
  StoredPlan stored{std::move(replan), {}};
  StoredSite& site = stored.site;
  site.touchdown = frame.GeoFromWorld(plan.touchdown_in_world);
  FinalPlaces places;
  places.start = frame.GeoFromWorld(approach.approach_start_in_world);
  places.loiter_center = frame.GeoFromWorld(approach.loiter_center_in_world);
  places.loiter_radius_m = approach.loiter_radius;
  places.is_right_turn = approach.loiter_direction == LoiterDirection::kRight;
  places.height_m = approach.approach_height;
  site.final_places = places;
  const double lift_m = site.touchdown.altitude_m - plan.touchdown_in_world.z();
  const ApproachProfile& profile = approach.profile;
  for (size_t i = 0; i < profile.distance.size(); ++i) {
    ProfilePoint point{profile.distance[i], profile.path_height[i] + lift_m, std::nullopt};
    if (std::isfinite(profile.terrain_height[i])) {
      point.terrain_m = profile.terrain_height[i] + lift_m;
    }
    site.profile.push_back(point);
  }
  return stored;
}

BoundingBox BoxOf(const StoredPlan& plan) {
  const LocalFrame frame(plan.site.touchdown);
  const Approach approach = ApproachIn(frame, plan);
  ElevationMap exact;
  const Polygon ground = CheckedGround(approach,
                                       exact,
                                       plan.replan.flight.aircraft,
                                       plan.replan.request.wind_in_world,
                                       plan.replan.flight.options.approach);
  const Eigen::Vector2d margin = Eigen::Vector2d::Constant(kBoxMarginM);
  const Eigen::Vector2d low = ground[0] - margin, high = ground[2] + margin;
  const GeoPoint south_west = frame.GeoFromWorld({low.x(), low.y(), 0.0});
  const GeoPoint north_east = frame.GeoFromWorld({high.x(), high.y(), 0.0});
  return {south_west.longitude_deg,
          south_west.latitude_deg,
          north_east.longitude_deg,
          north_east.latitude_deg};
}

Polygon CheckedGroundOf(const StoredPlan& plan,
                        const GeoPoint& map_origin,
                        const Grid& grid,
                        double position_sd_m) {
  return GroundOf(plan, ApproachIn(LocalFrame(map_origin), plan), grid, position_sd_m);
}

PlanCheck CheckPlan(const StoredPlan& plan, const GeoPoint& map_origin, const SiteMap& site_map) {
  const Approach approach = ApproachIn(LocalFrame(map_origin), plan);
  const SiteMap around = CroppedTo(plan, approach, site_map);
  if (around.map.elevation.empty()) return {};
  const ApproachCheck strict = CheckOn(Strict(plan, around), approach, plan);
  if (strict.is_covered && !strict.rejection) return {PlanVerdict::kHolds, std::nullopt, {}};
  return FailureOf(CheckOn(Lenient(plan, around), approach, plan).rejection).value_or(PlanCheck{});
}

std::optional<PlanCheck> BrokenByChanges(const StoredPlan& plan,
                                         const SiteMap& own_map,
                                         const SiteMap& changed_map) {
  const Approach approach = ApproachIn(LocalFrame(plan.replan.origin), plan);
  const auto broken = CheckOn(Lenient(plan, changed_map), approach, plan).rejection;
  if (!broken) return std::nullopt;
  const auto before = CheckOn(Lenient(plan, own_map), approach, plan).rejection;
  return IsSame(broken, before) ? std::nullopt : FailureOf(broken);
}

double ReachOfPlans(const RecallBounds& bounds) {
  double reach_m = 2200.0;
  ApproachOptions options;
  for (const std::string& aircraft_json : bounds.aircraft_jsons) {
    try {
      Aircraft aircraft = ParseAircraft(ParseJson(aircraft_json), "/aircraft");
      const double beside_m = aircraft.touchdown_uncertainty_m + aircraft.ground_roll_m;
      options.unknown_wind_mps = aircraft.landing_airspeed_mps;
      // PlanReach counts the lowest start height only.
      aircraft.approach_height_m *= options.start_height_ratios.back();
      reach_m = std::max(reach_m, PlanReach(aircraft, std::nullopt, 0.0, 0.0, options) + beside_m);
    } catch (const ApiError& error) {
      // The plans of this aircraft cannot be read either.
      spdlog::error("a stored aircraft cannot be used: {}", error.what());
    }
  }
  return reach_m;
}

}  // namespace freelsd
