// A site and a plan whose JSON is known.
#pragma once

#include <limits>

#include <nlohmann/json.hpp>

#include "api/api.h"

namespace freelsd {

inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
inline constexpr double kMaxPositionErrorDeg = 2e-9;
// A millimetre is what answers are rounded to; the earth's curve adds 1 mm in 110 m.
inline constexpr double kMaxAltitudeErrorM = 2e-3;

inline FlightContext Context() { return {"f1", "amsl", LocalFrame(GeoPoint{47.0, 8.0, 400.0})}; }

// Northbound final of 100 m from 12 m, left circle of 50 m radius (its centre is west).
inline Plan LandablePlan() {
  Plan plan;
  plan.verdict = Verdict::kLandable;
  plan.touchdown_in_world = {0, 0, 5};
  plan.hazard_distance = 24.5;
  plan.slope = 0.1;
  plan.roughness = 0.2;
  plan.score = 0.75;
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

inline Site LandableSite() {
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

inline nlohmann::json FeatureOf(const Site& site) {
  return SiteFeature("f1-4", site, Aircraft{}, "2026-01-01T00:00:00Z", Context());
}

}  // namespace freelsd
