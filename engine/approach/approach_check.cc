#include <algorithm>
#include <cmath>
#include <vector>

#include "engine/approach/attempt_verdict.h"
#include "engine/approach/path_check.h"
#include "engine/approach/touchdown.h"

namespace freelsd {
namespace {

// The stored approach. If the wind is unknown, also the same approach in the tail wind in which it
// must be clear.
std::vector<Approach> FlownWays(const Approach& approach,
                                const Aircraft& aircraft,
                                const std::optional<Eigen::Vector2d>& wind_in_world,
                                const ApproachOptions& options) {
  std::vector<Approach> ways{approach};
  if (wind_in_world) return ways;
  const double worst = options.unknown_wind_mps;
  const WindScenario downwind{DownwindApproachDistance(aircraft, worst),
                              LoiterRadius(aircraft, worst)};
  ways.push_back(MakeApproach(approach.touchdown_in_world,
                              approach.heading,
                              downwind,
                              approach.loiter_direction,
                              approach.approach_height));
  return ways;
}

Aircraft FromHeightOf(const Approach& approach, Aircraft aircraft) {
  aircraft.approach_height_m = approach.approach_height;
  return aircraft;
}

struct DiscCheck {
  // Distance of the nearest cell that is a hazard.
  std::optional<double> hazard_distance;
  bool is_seen = true;
  // Height of the ground at the touchdown. If the touchdown is unseen, the greatest height in the
  // disc, so that no obstacle seems higher than it is.
  std::optional<double> ground_height;
};

DiscCheck CheckDisc(const Eigen::Vector2d& touchdown,
                    double radius,
                    const ElevationMap& map,
                    const HazardLayers& hazards) {
  const Grid& grid = map.grid;
  const double cell = grid.cell_size_m;
  DiscCheck check;
  const auto middle = grid.CellAt(touchdown);
  const int half = static_cast<int>(std::ceil(radius / cell)) + 1;
  // Computed without CellAt, because the cell of the touchdown may lie outside the grid.
  const Eigen::Vector2d from_corner = (touchdown - grid.north_west_in_world) / cell;
  const int middle_row = static_cast<int>(std::floor(-from_corner.y()));
  const int middle_col = static_cast<int>(std::floor(from_corner.x()));
  for (int row = middle_row - half; row <= middle_row + half; ++row) {
    for (int col = middle_col - half; col <= middle_col + half; ++col) {
      const double distance = (grid.CellCenter(row, col) - touchdown).norm();
      if (distance >= radius) continue;
      const bool is_inside = row >= 0 && row < grid.num_rows && col >= 0 && col < grid.num_cols;
      const int hazard = is_inside ? hazards.hazard(row, col) : uchar{kUnseen};
      if (hazard == kUnseen) check.is_seen = false;
      if (hazard == kHazard && distance < check.hazard_distance.value_or(radius)) {
        check.hazard_distance = distance;
      }
      const double height = is_inside ? map.elevation(row, col) : std::nan("");
      if (height > check.ground_height.value_or(-HUGE_VAL)) check.ground_height = height;
    }
  }
  if (middle && std::isfinite(map.elevation(*middle))) check.ground_height = map.elevation(*middle);
  return check;
}

struct RollCheck {
  std::optional<RollSample> hazard;
  bool is_seen = true;
};

RollCheck CheckRoll(const Approach& approach,
                    const ClearanceSurface& surface,
                    const Aircraft& aircraft) {
  RollCheck check;
  for (const RollSample& sample : RollSamples(approach.heading, surface, aircraft)) {
    const Eigen::Vector2d place = approach.touchdown_in_world.head<2>() + sample.from_touchdown;
    const int row = surface.RowAt(place.y()), col = surface.ColAt(place.x());
    const int hazard = surface.IsInside(row, col) ? surface.hazard(row, col) : uchar{kUnseen};
    if (hazard == kUnseen) check.is_seen = false;
    if (hazard == kHazard && !check.hazard) check.hazard = sample;
  }
  return check;
}

// Height of the ground at the touchdown, estimated from the ground below the final. The ground is
// compared with the stored profile. The lower quartile of the differences is used, because new
// objects only raise the ground.
std::optional<double> GroundByProfile(const Approach& approach,
                                      const ClearanceSurface& surface,
                                      const Aircraft& aircraft,
                                      const ApproachOptions& options) {
  const ApproachProfile& stored = approach.profile;
  const ApproachProfile here = MakeProfile(approach, surface, aircraft, options);
  std::vector<double> heights;
  for (size_t i = 0; i < here.distance.size(); ++i) {
    // stored.distance is descending.
    const auto same = std::lower_bound(
        stored.distance.begin(), stored.distance.end(), here.distance[i], std::greater<>());
    if (same == stored.distance.end()) continue;
    const size_t j = static_cast<size_t>(same - stored.distance.begin());
    const double rise = here.terrain_height[i] - stored.terrain_height[j];
    if (std::isfinite(rise)) heights.push_back(approach.touchdown_in_world.z() + rise);
  }
  if (heights.empty()) return std::nullopt;
  const auto quartile = heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 4);
  std::nth_element(heights.begin(), quartile, heights.end());
  return *quartile;
}

Approach Seated(Approach approach, double ground_height) {
  const double rise = ground_height - approach.touchdown_in_world.z();
  approach.touchdown_in_world.z() += rise;
  approach.approach_start_in_world.z() += rise;
  approach.loiter_center_in_world.z() += rise;
  return approach;
}

Rejection BlockedBy(const Obstacle& obstacle,
                    RejectReason reason,
                    const std::string& what,
                    const Approach& approach) {
  const double ground = approach.touchdown_in_world.z();
  return {approach.touchdown_in_world,
          reason,
          what + " " + DescribeObstacle(obstacle, ground),
          obstacle.place_in_world};
}

// Adds final and circle of one way.
ApproachCheck WithPath(ApproachCheck check,
                       const Approach& approach,
                       const ClearanceSurface& surface,
                       const Aircraft& aircraft,
                       const ApproachOptions& options) {
  const PathCheck final_path = CheckFinal(approach, surface, aircraft, options, Depth::kEverything);
  check.is_covered &= final_path.num_unseen_steps == 0;
  if (check.rejection) return check;
  if (const auto& obstacle = final_path.obstacle) {
    const std::string what =
        "the final is blocked " + Metres(obstacle->distance) + " before touchdown";
    check.rejection = BlockedBy(*obstacle, RejectReason::kApproachBlocked, what, approach);
    return check;
  }
  const PathCheck circle = CheckCircle(approach, surface, aircraft);
  if (circle.obstacle) {
    const char* const what = "the loiter circle is blocked";
    check.rejection = BlockedBy(*circle.obstacle, RejectReason::kLoiterBlocked, what, approach);
  }
  return check;
}

std::optional<Rejection> BrokenBelow(const Approach& approach,
                                     const DiscCheck& disc,
                                     double required,
                                     const RollCheck& roll) {
  const Eigen::Vector3d& touchdown = approach.touchdown_in_world;
  if (disc.hazard_distance) {
    return Rejection{touchdown,
                     RejectReason::kNoSafeTouchdown,
                     "a hazard is " + Metres(*disc.hazard_distance) +
                         " from the touchdown point, " + Metres(required) + " are needed",
                     std::nullopt};
  }
  if (roll.hazard) {
    return Rejection{touchdown,
                     RejectReason::kNoSafeTouchdown,
                     "the ground roll meets a hazard " + Metres(roll.hazard->distance) +
                         " beyond the touchdown point",
                     std::nullopt};
  }
  return std::nullopt;
}

}  // namespace

ApproachCheck CheckApproach(const Approach& approach,
                            const ElevationMap& map,
                            const HazardLayers& hazards,
                            const Aircraft& profile,
                            const std::optional<Eigen::Vector2d>& wind_in_world,
                            const ApproachOptions& options) {
  RequireOneGrid(map, hazards);
  const double required = RequiredHazardDistance(map, profile, options);
  // The deviation of the map's position is unknown, so no place on it is certain.
  if (!std::isfinite(required)) return {};
  const Aircraft aircraft = WithPositionMargin(FromHeightOf(approach, profile), map, options);
  const ClearanceSurface surface = MakeClearanceSurfaceOfMap(map, hazards, aircraft, options);
  const DiscCheck disc = CheckDisc(approach.touchdown_in_world.head<2>(), required, map, hazards);
  const RollCheck roll = CheckRoll(approach, surface, aircraft);
  ApproachCheck check;
  check.is_covered = disc.is_seen && roll.is_seen;
  check.rejection = BrokenBelow(approach, disc, required, roll);
  const std::optional<double> ground = disc.ground_height
                                           ? disc.ground_height
                                           : GroundByProfile(approach, surface, aircraft, options);
  if (!ground) {
    check.is_covered = false;
    return check;
  }
  for (const Approach& way : FlownWays(approach, aircraft, wind_in_world, options)) {
    check = WithPath(std::move(check), Seated(way, *ground), surface, aircraft, options);
  }
  return check;
}

Polygon CheckedGround(const Approach& approach,
                      const ElevationMap& map,
                      const Aircraft& profile,
                      const std::optional<Eigen::Vector2d>& wind_in_world,
                      const ApproachOptions& options) {
  constexpr double kCellsAround = 5.0;
  const Aircraft aircraft = WithPositionMargin(FromHeightOf(approach, profile), map, options);
  const double reach = aircraft.path_half_width_m + kCellsAround * map.grid.cell_size_m +
                       RequiredHazardDistance(map, profile, options);
  const Eigen::Vector2d touchdown = approach.touchdown_in_world.head<2>();
  Eigen::Vector2d low = touchdown, high = touchdown;
  const auto include = [&](const Eigen::Vector2d& place, double radius) {
    low = low.cwiseMin(place - Eigen::Vector2d::Constant(radius));
    high = high.cwiseMax(place + Eigen::Vector2d::Constant(radius));
  };
  include(touchdown + aircraft.ground_roll_m * DirectionOf(approach.heading), reach);
  include(touchdown, reach);
  for (const Approach& way : FlownWays(approach, aircraft, wind_in_world, options)) {
    include(way.approach_start_in_world.head<2>(), reach);
    include(way.loiter_center_in_world.head<2>(), way.loiter_radius + reach);
  }
  return {low, {high.x(), low.y()}, high, {low.x(), high.y()}};
}

}  // namespace freelsd
