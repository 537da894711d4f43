// Input: where an aircraft without power is, the wind, a stored approach and map. Output: how high
// it arrives at the approach's start. Not part of the pipeline: emergency recall asks it.
//
// The aircraft glides through moving air: it turns towards the place, flies straight, and turns
// onto the final (a shortest path of bounded curvature, Dubins 1957, in the air's own frame, in
// which the place drifts against the wind). What is unknown always costs height.
#pragma once

#include <optional>

#include "engine/approach/approach.h"

namespace freelsd {

struct GlideOptions {
  // Speed of a wind that is not known; the worst of its directions counts. The same as
  // approach.unknown_wind_mps.
  double unknown_wind_mps = 5.5;
  // Directions tried for an unknown wind, and for an unknown heading; the worst one counts.
  int num_unknown_winds = 8;
  int num_unknown_headings = 16;
  // Height kept over the terrain of stored maps on the way.
  double terrain_clearance_m = 10.0;
  // Taken off the arrival height where the altitude's datum is unknown or another one: the geoid
  // lies up to 106 m off the ellipsoid.
  double datum_penalty_m = 110.0;

  // Throws std::invalid_argument: "glide.unknown_wind_mps = -1: must be in [0, 50]".
  void Check() const;
};

struct GlideStart {
  Eigen::Vector3d position_in_world = Eigen::Vector3d::Zero();
  // Direction of travel, radians clockwise from north.
  std::optional<double> heading;
  std::optional<Eigen::Vector2d> wind_in_world;
};

struct Glide {
  double time_s = 0.0;
  double height_lost_m = 0.0;
  // World z over the start of the final.
  double arrival_height_m = 0.0;
};

// The aircraft as it lands without power: the final is at least as steep as the glide. Throws
// std::invalid_argument for a glide ratio outside the aircraft's bounds.
Aircraft Unpowered(Aircraft aircraft, std::optional<double> glide_ratio);

// The worst over what is unknown: the directions of an unknown wind or heading, or the known wind
// turned by up to the aircraft's crosswind uncertainty. Nothing where some wind is too strong to
// get there. `aircraft` is unpowered.
std::optional<Glide> GlideTo(const GlideStart& start,
                             const Eigen::Vector3d& approach_start_in_world,
                             double final_heading,
                             const Aircraft& aircraft,
                             const GlideOptions& options);

// Speeds of an aircraft without power in still air, flying straight.
struct StraightGlide {
  double airspeed_mps = 0.0;  // horizontal
  double sink_rate_mps = 0.0;
};

StraightGlide StraightGlideOf(const Aircraft& aircraft);

// Least height that any way to within `within_m` of a place costs: straight, no turn, the known
// wind as it is, an unknown one calm. Never more than GlideTo says. Nothing where the wind is too
// strong. `glide` is that of the aircraft, which has many places to choose from.
std::optional<double> LeastHeightLost(const GlideStart& start,
                                      const Eigen::Vector2d& place_in_world,
                                      double within_m,
                                      const StraightGlide& glide);

// Least height of the straight line over a map's upper surface (ElevationMap::upper), metres;
// nothing where the line meets no seen cell. Both ends in the map's world.
std::optional<double> LeastHeightOver(const Grid& grid,
                                      const cv::Mat1f& upper,
                                      const Eigen::Vector3d& begin_in_world,
                                      const Eigen::Vector3d& end_in_world);

}  // namespace freelsd
