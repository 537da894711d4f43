#include "engine/approach/go_around/go_around.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace freelsd {
namespace {

// Ground below one step of the line through final and climb.
struct GroundBelow {
  // From touchdown, positive ahead of it.
  double along = 0.0;
  // Above touchdown; empty where nothing shows a height.
  std::optional<double> top;
  bool is_unseen = false;
};

// In order, from the start of the shortest final to the end of the map.
std::vector<GroundBelow> GroundAlong(const Approach& approach,
                                     double from,
                                     double step,
                                     const ClearanceSurface& surface,
                                     const Aircraft& aircraft) {
  const Corridor corridor =
      MakeCorridor(approach.heading, aircraft.path_half_width_m, surface.cell_size);
  const Eigen::Vector2d forward = DirectionOf(approach.heading);
  std::vector<GroundBelow> ground;
  for (int i = 0;; ++i) {
    const double along = -from + i * step;
    const Eigen::Vector2d place = approach.touchdown_in_world.head<2>() + along * forward;
    const Slice slice = SliceAt(place, corridor, surface);
    // The map is convex, and the touchdown lies on it.
    if (along > 0.0 && !slice.is_on_map) return ground;
    GroundBelow below{along, std::nullopt, slice.is_unseen};
    if (slice.height != kNoHeight) below.top = slice.height - approach.touchdown_in_world.z();
    ground.push_back(below);
  }
}

// The climb from a place `distance` before touchdown on the final.
struct Climb {
  // Heights per metre over ground.
  double final_slope = 0.0;
  double climb_slope = 0.0;

  // Above touchdown.
  double HeightAt(double along, double distance) const {
    return final_slope * distance + climb_slope * (along + distance);
  }
  // Where a climb must begin to be at this height there.
  double DistanceFor(double along, double height) const {
    return (height - climb_slope * along) / (final_slope + climb_slope);
  }
};

Climb ClimbOf(const Approach& approach, const Aircraft& aircraft) {
  return {approach.approach_height / approach.approach_distance, ClimbSlope(approach, aircraft)};
}

// Climbs that begin at these distances before touchdown do not clear some ground.
struct Blocked {
  double from = 0.0;
  double to = 0.0;
};

std::vector<Blocked> BlockedBy(const std::vector<GroundBelow>& ground,
                               const Climb& climb,
                               const ClearanceSurface& surface,
                               const Aircraft& aircraft) {
  constexpr double kHigh = std::numeric_limits<double>::infinity();
  std::vector<Blocked> blocked;
  for (const GroundBelow& below : ground) {
    if (!below.top) continue;
    const double wanted = WantedClearance(std::abs(below.along), kHigh, surface, aircraft);
    // A climb from nearer than the ground begins behind it.
    blocked.push_back({-below.along, climb.DistanceFor(below.along, *below.top + wanted)});
  }
  return blocked;
}

// The least distance from `least` on that is not blocked.
double FirstClear(std::vector<Blocked> blocked, double least) {
  std::sort(blocked.begin(), blocked.end(), [](const Blocked& a, const Blocked& b) {
    return a.from < b.from;
  });
  double distance = least;
  for (const Blocked& each : blocked) {
    if (each.from > distance) break;
    distance = std::max(distance, each.to);
  }
  return distance;
}

double UnseenRatio(const std::vector<GroundBelow>& ground, double from, double to, double step) {
  double num_steps = 0.0, num_unseen = 0.0;
  for (const GroundBelow& below : ground) {
    if (below.along < from || below.along > to) continue;
    ++num_steps;
    num_unseen += below.is_unseen ? 1.0 : 0.0;
  }
  const double num_off_map = std::ceil(std::max(0.0, to - ground.back().along) / step);
  if (num_steps + num_off_map <= 0.0) return 0.0;
  return (num_unseen + num_off_map) / (num_steps + num_off_map);
}

double LastSeen(const std::vector<GroundBelow>& ground) {
  const auto last = std::find_if(
      ground.rbegin(), ground.rend(), [](const auto& below) { return below.top.has_value(); });
  return last == ground.rend() ? 0.0 : last->along;
}

}  // namespace

std::optional<GoAround> FindGoAround(const std::vector<Approach>& scenarios,
                                     const ClearanceSurface& surface,
                                     const Aircraft& aircraft,
                                     const ApproachOptions& options) {
  const Approach& flown = scenarios.front();
  double shortest = flown.approach_distance;
  for (const Approach& each : scenarios) shortest = std::min(shortest, each.approach_distance);
  const double step = AlongStep(surface, options);
  const std::vector<GroundBelow> ground = GroundAlong(flown, shortest, step, surface, aircraft);
  std::vector<Blocked> blocked;
  double least = aircraft.touchdown_uncertainty_m;
  for (const Approach& each : scenarios) {
    const Climb climb = ClimbOf(each, aircraft);
    least = std::max(least, aircraft.safety_margin_m / climb.final_slope);
    const std::vector<Blocked> in_this = BlockedBy(ground, climb, surface, aircraft);
    blocked.insert(blocked.end(), in_this.begin(), in_this.end());
  }
  const double distance = FirstClear(std::move(blocked), least);
  if (distance > shortest) return std::nullopt;
  const Climb climb = ClimbOf(flown, aircraft);
  const double at_height =
      (flown.approach_height - climb.final_slope * distance) / climb.climb_slope - distance;
  const double end = std::max(at_height, LastSeen(ground));
  const auto on_line = [&](double along) {
    const Eigen::Vector2d place =
        flown.touchdown_in_world.head<2>() + along * DirectionOf(flown.heading);
    return Eigen::Vector3d(
        place.x(), place.y(), flown.touchdown_in_world.z() + climb.HeightAt(along, distance));
  };
  return GoAround{.no_return_distance = distance,
                  .start_in_world = on_line(-distance),
                  .end_in_world = on_line(end),
                  .climb_angle = std::atan(climb.climb_slope),
                  .unseen_ratio = UnseenRatio(ground, -distance, end, step)};
}

ClearanceSurface MakeClimbSurface(const Approach& approach,
                                  const ElevationMap& map,
                                  const HazardLayers& hazards,
                                  const Aircraft& aircraft,
                                  const ApproachOptions& options) {
  constexpr double kCellsAround = 4.0;
  const Eigen::Vector2d touchdown = approach.touchdown_in_world.head<2>();
  const Eigen::Vector2d forward = DirectionOf(approach.heading);
  // Far enough to leave the map.
  const double ahead = map.grid.cell_size_m * std::hypot(map.grid.num_rows, map.grid.num_cols);
  const Polygon line{touchdown - approach.approach_distance * forward, touchdown + ahead * forward};
  // Cells beyond the corridor decide whether a cell in it is bare.
  const double margin = aircraft.path_half_width_m + options.bare_ground_radius_m +
                        kCellsAround * map.grid.cell_size_m;
  return MakeHeightSurface(map, hazards, map.grid.CellsAround(line, margin), aircraft, options);
}

}  // namespace freelsd
