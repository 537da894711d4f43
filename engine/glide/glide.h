// Input: position without power, wind, a stored approach and map. Output: height on arrival at the
// approach's start. Not part of the pipeline; emergency recall uses it.
//
// The aircraft turns towards the approach's start, flies straight, and turns onto the final. This
// is the shortest path of bounded curvature (Dubins 1957) in the frame of the moving air. In this
// frame, the approach's start moves against the wind.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "engine/approach/approach.h"
#include "engine/glide/reach.h"
#include "engine/glide/shortest_turns.h"

namespace freelsd {

struct GlideOptions {
  // Wind speed assumed by GlideTo if the wind is unknown. The worst direction is assumed. The
  // default is that of approach.unknown_wind_mps.
  double unknown_wind_mps = 5.5;
  // Number of directions tried for an unknown wind, and for an unknown heading. The worst one
  // counts.
  int num_unknown_winds = 8;
  int num_unknown_headings = 16;
  // Standard deviations of a known wind that are reckoned with.
  double num_wind_deviations = 2.0;
  // Clearance to keep above the terrain of stored maps on the way to the approach's start.
  double terrain_clearance_m = 10.0;
  // Subtracted from the arrival height if two altitudes cannot be compared exactly, and the geoid's
  // grid is not installed. Two altitudes cannot be compared exactly if their datums differ or if a
  // datum is unknown. The geoid lies up to 106 m from the ellipsoid.
  double datum_penalty_m = 110.0;
  // Surplus height at the start of the final that needs no longer path and no warning.
  double max_surplus_m = 2.0;
  // Height that the uncertainty of the wind may cost a longer path after the last point at which
  // the path can be cut short (decision 0023).
  double max_shortfall_m = 5.0;

  // Throws std::invalid_argument: "glide.unknown_wind_mps = -1: must be in [0, 50]".
  void Check() const;
};

struct GlideStart {
  Eigen::Vector3d position_in_world = Eigen::Vector3d::Zero();
  // Direction of travel, radians clockwise from north.
  std::optional<double> heading;
  std::optional<Eigen::Vector2d> wind_in_world;
  // Standard deviation of the known wind in each axis; 0: unknown.
  double wind_sd_mps = 0.0;
  // How far the known wind may have turned to either side, radians.
  double wind_turn = 0.0;
};

struct Glide {
  double time_s = 0.0;
  double height_lost_m = 0.0;
  // World z of the aircraft when it is over the start of the final.
  double arrival_height_m = 0.0;
};

// The same aircraft without power: its final is at least as steep as its glide. If `glide_ratio` is
// given, it replaces the glide ratio of the aircraft. Throws std::invalid_argument if the ratio is
// outside its bounds.
Aircraft Unpowered(Aircraft aircraft, std::optional<double> glide_ratio);

// The result with the lowest arrival, over all combinations of these values:
// - Known wind: the wind itself, and turned to either side by the crosswind uncertainty or by
//   wind_turn. If its standard deviation is known, also the edge of the sector that has these
//   directions and contains all winds within two deviations.
// - Unknown wind: calm, and unknown_wind_mps from every direction.
// - Unknown heading: every heading.
// Nothing if one of these winds is too strong to arrive. `aircraft` must be Unpowered.
std::optional<Glide> GlideTo(const GlideStart& start,
                             const Eigen::Vector3d& approach_start_in_world,
                             double final_heading,
                             const Aircraft& aircraft,
                             const GlideOptions& options);

struct DescentPoint {
  Eigen::Vector3d position_in_world = Eigen::Vector3d::Zero();
  double time_s = 0.0;
};

// The whole path to a stored approach in one wind. Its parts in order:
// - turns and a straight glide to the start of the final, or to a point of the loiter circle and
//   along the circle to the start of the final;
// - circles there that lose surplus height, if there is enough for a circle;
// - the final.
struct Descent {
  // From the aircraft to the touchdown, straight between neighbours.
  std::vector<DescentPoint> points;
  // Index of the point up to which the pilot can still leave out the rest of a longer way.
  size_t decision = 0;
  // Index of the point from which the path follows the loiter circle, or is the final.
  size_t joining = 0;
  // Index of the point at which the path first reaches the start of the final.
  size_t arrival = 0;
  // Index of the point at which the final begins. Equals `arrival` if no circle is flown.
  size_t final_start = 0;
  int num_circles = 0;
  // Height above the planned final at its start. The pilot must lose it on the final.
  double surplus_height_m = 0.0;
};

// The shortest path in the wind of `start`. An unknown wind counts as calm. If the heading is
// unknown, the heading that loses the most height is assumed. The circles are the loiter circles of
// the approach, because the planner has checked them. They are flown at landing speed. The rest
// that is too small for a circle is the surplus height. Nothing if the aircraft arrives below the
// start of the final, or if the wind is too strong. `aircraft` must be Unpowered.
std::optional<Descent> PlanDescent(const GlideStart& start,
                                   const Approach& approach,
                                   const Aircraft& aircraft,
                                   const GlideOptions& options);

// The first longer way to the start of the final that `takes` takes, of those that leave hardly any
// surplus height there (0.5 m at most): a longer straight piece, wider turns, a bend, a wider
// circle. Ways that can be cut short for long come first. Last come ways that join the loiter
// circle where its rest loses the height (all but options.max_surplus_m): the planner has checked
// the ground below. Nothing where PlanDescent gives nothing, and where no such way is found or
// taken.
std::optional<Descent> PlanLongerDescent(const GlideStart& start,
                                         const Approach& approach,
                                         const Aircraft& aircraft,
                                         const GlideOptions& options,
                                         const std::function<bool(const Descent&)>& takes);

// Speeds of an aircraft without power in still air, flying straight.
struct StraightGlide {
  double airspeed_mps = 0.0;  // horizontal
  double sink_rate_mps = 0.0;
};

StraightGlide StraightGlideOf(const Aircraft& aircraft);

// Lower bound of the height lost on any path that ends within `within_m` of a place. It assumes a
// straight line without turns. An unknown wind counts as calm. The bound never exceeds the result
// of GlideTo. Nothing if the wind is too strong. Compute `glide` once for many places.
std::optional<double> LeastHeightLost(const GlideStart& start,
                                      const Eigen::Vector2d& place_in_world,
                                      double within_m,
                                      const StraightGlide& glide);

// Least height of a straight line above a map's upper surface (ElevationMap::upper), metres;
// nothing if the line crosses no seen cell. Both ends are in the world frame of the map.
std::optional<double> LeastHeightOver(const Grid& grid,
                                      const cv::Mat1f& upper,
                                      const Eigen::Vector3d& begin_in_world,
                                      const Eigen::Vector3d& end_in_world);

}  // namespace freelsd
