// Input: a finished map, the sites on it, the flight that made it. Output: the legs to fly next,
// each with the places that its photographs may turn landable, and the expected gain.
//
// The ground is cut into squares. A square holds one landing, so its landing value is at most 1: 1
// where the landing is landable, `unverified_value` where its circle is not wholly seen, 0 where
// there is none. What is not known of the best landing (ground, final, circle) keeps the expected
// value of a square below what it could be. Photographs of unknown cells raise it, if these cells
// turn out as well as the ground around them. The gain of a leg is the sum over all squares.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "engine/approach/approach.h"
#include "engine/flight/flight.h"
#include "engine/selection/selection.h"

namespace freelsd {

struct NextLookOptions {
  int num_legs = 2;
  double leg_length_m = 300.0;
  // Directions of legs that are tried, evenly spaced over half a turn.
  int num_leg_directions = 12;
  // Legs lie on the map, or this far beyond its edge.
  double max_outside_m = 100.0;
  // Least share of the ground under a leg that photographs have shown already: they tie the new
  // photographs to the map.
  double min_shared_ratio = 0.15;
  // --- What is known ---
  // A cell that so many photographs show is known. A cell that was refused after fewer of them
  // counts as partly unknown.
  int num_views_to_know = 3;
  // A cell that was refused because of its kind alone, with at least this posterior of grass, is in
  // doubt: it counts as unknown by the share of its posterior.
  double min_doubtful_posterior = 0.5;
  // Unseen ground is expected to be like the seen ground around it. Over this distance from there,
  // the expectation falls towards the mean of the map.
  double prospect_length_m = 60.0;
  // Share s of the cells of a landing that are known: the chance that nothing is missing is s to
  // the power of this.
  double missing_exponent = 4.0;
  // --- Places ---
  // Side of the squares, as BackendOptions::map_site_extent_m.
  double place_extent_m = 60.0;
  // Touchdowns that are tried in a square lie this far apart.
  double touchdown_spacing_m = 20.0;
  // Landing value of an unverified site.
  double unverified_value = 0.5;
  // --- Search ---
  double cell_size_m = 5.0;
  // Legs that promise most by a cheap measure; only their gains are computed.
  int num_shortlisted_legs = 200;
  // Least expected gain of a place that is told with a leg.
  double min_told_gain = 0.05;
  // Least height of a leg above all that is seen near it.
  double min_clearance_m = 40.0;

  // Throws std::invalid_argument: "next_look.num_legs = 0: must be in [1, 8]".
  void Check() const;
};

// What the planner said so far.
struct SiteSoFar {
  Verdict verdict = Verdict::kRejected;
  Eigen::Vector3d touchdown_in_world = Eigen::Vector3d::Zero();
  // Of an unverified site: its final and circle.
  std::optional<PlannedLanding> landing = std::nullopt;
};

struct LookRequest {
  const ElevationMap& map;
  // With the limits of the aircraft.
  const HazardLayers& layers;
  // Views that saw each cell.
  const cv::Mat1b& num_views;
  const std::vector<SiteSoFar>& sites;
  const Rig& rig;
  // Poses of the photographs so far, in the order of flight; at least one.
  const std::vector<Rigid3d>& flown;
  const Aircraft& aircraft;
  std::optional<Eigen::Vector2d> wind_in_world = std::nullopt;
  // Both ends of all legs lie in it. Empty: the map, and max_outside_m beyond it.
  std::optional<Box> area = std::nullopt;
  // Called before each leg that is tried; to give up, it throws.
  std::function<void()> before_leg = [] {};
};

// A square whose landing value is expected to grow.
struct LookedPlace {
  // The touchdown that promises most there.
  Eigen::Vector3d touchdown_in_world = Eigen::Vector3d::Zero();
  // Index of the square's best site that is not landable; nothing where there is no site.
  std::optional<size_t> site;
  double expected_gain = 0.0;
};

struct LookLeg {
  Eigen::Vector3d from_in_world = Eigen::Vector3d::Zero();
  Eigen::Vector3d to_in_world = Eigen::Vector3d::Zero();
  // Direction of travel, radians clockwise from north.
  double heading = 0.0;
  // Length of the way to the leg with the aircraft's turns, from the last photograph or from the
  // leg before.
  double transit_m = 0.0;
  // Gain beyond that of the legs that were chosen before it.
  double expected_gain = 0.0;
  // Largest gain first.
  std::vector<LookedPlace> places;
};

struct NextLook {
  // In the order of flight. Fewer than asked for if no other leg promises anything.
  std::vector<LookLeg> legs;
  // Sum over the legs.
  double expected_gain = 0.0;
  // Of the sites so far.
  double landing_value = 0.0;
  // Between two photographs, and what one of them shows: along and across the leg.
  double photo_spacing_m = 0.0;
  Eigen::Vector2d photo_extent_m = Eigen::Vector2d::Zero();
  double height_above_ground_m = 0.0;
  double turn_radius_m = 0.0;
};

// The same request gives the same answer. Throws std::invalid_argument if the options are invalid,
// if map and layers have different grids, or if nothing was flown.
NextLook ChooseNextLook(const LookRequest& request, const NextLookOptions& options);

}  // namespace freelsd
