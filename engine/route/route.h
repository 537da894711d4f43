// Input: the points of a planned flight, airspeed, wind. Output: where the aircraft is at each
// second; the same route higher or further aside. Not part of the pipeline; the insurance of a
// route uses it.
//
// Between two points, latitude, longitude and altitude change evenly. Turns take no time.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "engine/geometry/geometry.h"

namespace freelsd {

struct RouteOptions {
  // Time between two moments.
  double moment_period_s = 1.0;
  // A longer route is refused.
  int max_num_moments = 7200;
  // Sideways metres per metre flown where a changed route leaves the planned one, and where it
  // comes back.
  double max_offset_slope = 0.5;

  // Throws std::invalid_argument: "route.moment_period_s = 0: must be in [0.1, 60]".
  void Check() const;
};

struct RouteMoment {
  double time_s = 0.0;
  GeoPoint place;
  // Direction of travel over ground, in [0, 360).
  double heading_deg = 0.0;
  // Along the route, from its first point.
  double distance_m = 0.0;
};

// The first moment is at the first point; the last one is at most one period before the last
// point. A point after itself takes no time. Throws std::invalid_argument: "route[3]: …" if this
// point cannot be reached in this wind, "route: …" if the route is too long or has no length.
std::vector<RouteMoment> MomentsOf(const std::vector<GeoPoint>& route,
                                   double airspeed_mps,
                                   const Eigen::Vector2d& wind_in_world,
                                   const RouteOptions& options);

// A part of a route that is flown elsewhere. The change is whole from from_m to to_m; before and
// after them it grows and fades with the greatest slope. The route's ends stay where they are, so
// near them the change may not be whole.
struct RouteChange {
  // Along the route.
  double from_m = 0.0;
  double to_m = 0.0;
  double climb_m = 0.0;
  // Metres of climb per metre flown. Positive.
  double climb_slope = 0.05;
  // East, north; the same for the whole part.
  Eigen::Vector2d offset_m = Eigen::Vector2d::Zero();
};

// Points along the route at which the change begins, is whole, begins to fade, and ends.
struct ChangedPart {
  double begin_m = 0.0;
  double whole_from_m = 0.0;
  double whole_to_m = 0.0;
  double end_m = 0.0;
};

ChangedPart PartOf(const std::vector<GeoPoint>& route,
                   const RouteChange& change,
                   const RouteOptions& options);

// The points of `route` and of the part, all moved as far as the change says.
std::vector<GeoPoint> Changed(const std::vector<GeoPoint>& route,
                              const RouteChange& change,
                              const RouteOptions& options);

}  // namespace freelsd
