#include "engine/approach/path_check.h"

#include <algorithm>
#include <cmath>

namespace freelsd {
namespace {

// Near touchdown this share of the path's height is enough clearance (decision 0019).
constexpr double kShareOfPathHeight = 0.5;

// Upper bound of a slice: the highest cell within reach. If this is clear, the slice is clear.
Slice GlanceAt(const Eigen::Vector2d& place, const ClearanceSurface& surface) {
  const int row = surface.RowAt(place.y()), col = surface.ColAt(place.x());
  if (!surface.IsInside(row, col)) return {.is_unseen = true, .is_free = false};
  return {.height = surface.corridor_height(row, col),
          .row = row,
          .col = col,
          .is_unseen = surface.corridor_is_unseen(row, col) != 0,
          .is_on_map = true};
}

bool HasFailed(const PathCheck& check) { return check.obstacle || check.num_unseen_steps > 0; }

// Whether all slices from the first one are free. A glance does not tell, so slices that it skipped
// are looked at when a later one asks.
class FreeRunSoFar {
 public:
  FreeRunSoFar(const Approach& approach, const Corridor& corridor, const ClearanceSurface& surface)
      : touchdown_(approach.touchdown_in_world.head<2>()),
        forward_(DirectionOf(approach.heading)),
        corridor_(corridor),
        surface_(surface) {}

  // `slice` is the one at step i. Steps are asked for in ascending order.
  bool Reaches(const std::vector<double>& steps, size_t i, const Slice& slice) {
    while (!is_broken_ && num_free_ < i) {
      Add(SliceAt(touchdown_ - steps[num_free_] * forward_, corridor_, surface_));
    }
    if (!is_broken_ && num_free_ == i) Add(slice);
    return !is_broken_;
  }

 private:
  void Add(const Slice& slice) {
    is_broken_ = !slice.is_free;
    num_free_ += slice.is_free;
  }

  const Eigen::Vector2d touchdown_, forward_;
  const Corridor& corridor_;
  const ClearanceSurface& surface_;
  size_t num_free_ = 0;
  bool is_broken_ = false;
};

// The highest cell of the corridor around a place.
Eigen::Vector3d HighestAround(const Eigen::Vector2d& place, const ClearanceSurface& surface) {
  const int center_row = surface.RowAt(place.y()), center_col = surface.ColAt(place.x());
  const int half = static_cast<int>(std::ceil(surface.corridor_radius / surface.cell_size));
  Eigen::Vector3d highest(place.x(), place.y(), kNoHeight);
  for (int row = center_row - half; row <= center_row + half; ++row) {
    for (int col = center_col - half; col <= center_col + half; ++col) {
      if (!surface.IsInside(row, col) || surface.height(row, col) <= highest.z()) continue;
      const Eigen::Vector2d cell = surface.CellCenter(row, col);
      const Eigen::Vector2d center = surface.CellCenter(center_row, center_col);
      if ((cell - center).norm() > surface.corridor_radius) continue;
      highest = {cell.x(), cell.y(), surface.height(row, col)};
    }
  }
  return highest;
}

}  // namespace

Slice SliceAt(const Eigen::Vector2d& place,
              const Corridor& corridor,
              const ClearanceSurface& surface) {
  Slice slice;
  for (int i = -corridor.num_each_side; i <= corridor.num_each_side; ++i) {
    const Eigen::Vector2d sample = place + (i * corridor.spacing) * corridor.across;
    const int row = surface.RowAt(sample.y()), col = surface.ColAt(sample.x());
    if (!surface.IsInside(row, col)) {
      slice.is_unseen = true;
      slice.is_free = false;
      continue;
    }
    slice.is_on_map = true;
    if (surface.is_unseen(row, col)) slice.is_unseen = true;
    if (surface.hazard(row, col) != kFree) slice.is_free = false;
    if (surface.height(row, col) <= slice.height) continue;
    slice.height = surface.height(row, col);
    slice.row = row;
    slice.col = col;
  }
  return slice;
}

double AlongStep(const ClearanceSurface& surface, const ApproachOptions& options) {
  return std::min(options.path_step_m, kAlongSpacing * surface.cell_size);
}

std::vector<double> FinalSteps(const ClearanceSurface& surface,
                               const WindScenario& scenario,
                               const Aircraft& aircraft,
                               const ApproachOptions& options) {
  return Steps(
      aircraft.touchdown_uncertainty_m, scenario.approach_distance, AlongStep(surface, options));
}

double WantedClearance(double distance,
                       double path_height,
                       const ClearanceSurface& surface,
                       const Aircraft& aircraft) {
  return std::min(aircraft.safety_margin_m, kShareOfPathHeight * path_height) +
         surface.lean * distance;
}

int NumCircleSteps(double radius, const ClearanceSurface& surface) {
  return std::max(4, static_cast<int>(std::ceil(2.0 * kPi * radius / surface.circle_step)));
}

std::vector<RollSample> RollSamples(double heading,
                                    const ClearanceSurface& surface,
                                    const Aircraft& aircraft) {
  std::vector<RollSample> samples;
  if (aircraft.ground_roll_m <= 0.0) return samples;
  const Corridor corridor = MakeCorridor(heading, aircraft.path_half_width_m, surface.cell_size);
  const Eigen::Vector2d forward = DirectionOf(heading);
  const double end = aircraft.ground_roll_m + surface.HalfDiagonal();
  for (double distance : Steps(0.0, end, kAlongSpacing * surface.cell_size)) {
    for (int i = -corridor.num_each_side; i <= corridor.num_each_side; ++i) {
      samples.push_back({distance * forward + (i * corridor.spacing) * corridor.across, distance});
    }
  }
  return samples;
}

PathCheck WithObstacle(PathCheck check, const Obstacle& nearest) {
  check.min_clearance = std::min(check.min_clearance, nearest.clearance);
  if (nearest.wanted > 0.0) {
    check.min_clearance_ratio =
        std::min(check.min_clearance_ratio, nearest.clearance / nearest.wanted);
  }
  if (nearest.Deficit() <= 0.0) return check;
  if (!check.obstacle || nearest.Deficit() > check.obstacle->Deficit()) check.obstacle = nearest;
  return check;
}

PathCheck Worse(const PathCheck& a, const PathCheck& b) {
  PathCheck worse = a.UnseenRatio() >= b.UnseenRatio() ? a : b;
  worse.min_clearance = std::min(a.min_clearance, b.min_clearance);
  worse.min_clearance_ratio = std::min(a.min_clearance_ratio, b.min_clearance_ratio);
  worse.clear_ratio = std::min(a.clear_ratio, b.clear_ratio);
  worse.obstacle = a.obstacle;
  if (b.obstacle && (!a.obstacle || b.obstacle->Deficit() > a.obstacle->Deficit())) {
    worse.obstacle = b.obstacle;
  }
  return worse;
}

double FreeRun(const Approach& approach,
               const ClearanceSurface& surface,
               const Aircraft& aircraft,
               const ApproachOptions& options) {
  const Corridor corridor =
      MakeCorridor(approach.heading, aircraft.path_half_width_m, surface.cell_size);
  const Eigen::Vector2d forward = DirectionOf(approach.heading);
  const WindScenario scenario{approach.approach_distance, approach.loiter_radius};
  double run = 0.0;
  for (const double distance : FinalSteps(surface, scenario, aircraft, options)) {
    const Eigen::Vector2d place = approach.touchdown_in_world.head<2>() - distance * forward;
    if (!SliceAt(place, corridor, surface).is_free) break;
    run = distance;
  }
  return run;
}

PathCheck CheckFinal(const Approach& approach,
                     const ClearanceSurface& surface,
                     const Aircraft& aircraft,
                     const ApproachOptions& options,
                     Depth depth) {
  const Corridor corridor =
      MakeCorridor(approach.heading, aircraft.path_half_width_m, surface.cell_size);
  const Eigen::Vector2d forward = DirectionOf(approach.heading);
  const double slope = approach.approach_height / approach.approach_distance;
  const WindScenario scenario{approach.approach_distance, approach.loiter_radius};
  PathCheck check;
  bool was_on_map = false;
  FreeRunSoFar free_run(approach, corridor, surface);
  const std::vector<double> steps = FinalSteps(surface, scenario, aircraft, options);
  for (size_t i = 0; i < steps.size(); ++i) {
    const double distance = steps[i];
    const Eigen::Vector2d place = approach.touchdown_in_world.head<2>() - distance * forward;
    const double path = slope * distance;
    const double height = approach.touchdown_in_world.z() + path;
    const double wanted = WantedClearance(distance, path, surface, aircraft);
    if (depth == Depth::kUntilFailure) {
      const Slice glance = GlanceAt(place, surface);
      const double clearance = height - glance.height;
      if (!glance.is_unseen && clearance >= wanted) {
        check.min_clearance = std::min(check.min_clearance, clearance);
        ++check.num_steps;
        continue;
      }
    }
    const Slice slice = SliceAt(place, corridor, surface);
    was_on_map |= slice.is_on_map;
    ++check.num_steps;
    if (slice.is_unseen && check.num_unseen_steps++ == 0) check.first_unseen_distance = distance;
    if (free_run.Reaches(steps, i, slice)) {
      check.min_clearance = std::min(check.min_clearance, height - slice.height);
    } else if (slice.height != kNoHeight) {
      const Eigen::Vector2d highest = surface.CellCenter(slice.row, slice.col);
      check = WithObstacle(check,
                           {.place_in_world = {highest.x(), highest.y(), slice.height},
                            .distance = distance,
                            .clearance = height - slice.height,
                            .wanted = wanted});
    }
    if (!HasFailed(check)) continue;
    check.clear_ratio = std::min(check.clear_ratio, distance / approach.approach_distance);
    if (depth == Depth::kUntilFailure) break;
    if (was_on_map && !slice.is_on_map) break;  // convex map: the rest is outside too
  }
  return check;
}

PathCheck CheckCircle(const Approach& approach,
                      const ClearanceSurface& surface,
                      const Aircraft& aircraft) {
  PathCheck check;
  check.num_steps = NumCircleSteps(approach.loiter_radius, surface);
  const Eigen::Vector2d center = approach.loiter_center_in_world.head<2>();
  const double height = approach.loiter_center_in_world.z();
  const Eigen::Rotation2Dd one_step(2.0 * kPi / check.num_steps);
  const Eigen::Matrix2d rotation = one_step.toRotationMatrix();
  Eigen::Vector2d arm = approach.approach_start_in_world.head<2>() - center;
  const Eigen::Vector2d touchdown = approach.touchdown_in_world.head<2>();
  Obstacle nearest;
  bool is_something_seen = false;
  Eigen::Vector2d worst_place = center;
  for (int i = 0; i < check.num_steps; ++i, arm = rotation * arm) {
    const Eigen::Vector2d place = center + arm;
    const int row = surface.RowAt(place.y()), col = surface.ColAt(place.x());
    if (!surface.IsInside(row, col)) {
      ++check.num_unseen_steps;
      continue;
    }
    check.num_unseen_steps += surface.corridor_is_unseen(row, col);
    if (surface.corridor_height(row, col) == kNoHeight) continue;
    const double distance = (place - touchdown).norm();
    const Obstacle here{.distance = distance,
                        .clearance = height - surface.corridor_height(row, col),
                        .wanted = aircraft.safety_margin_m + surface.lean * distance};
    if (is_something_seen && here.Deficit() <= nearest.Deficit()) continue;
    is_something_seen = true;
    nearest = here;
    worst_place = place;
  }
  if (!is_something_seen) return check;
  if (nearest.Deficit() > 0.0) nearest.place_in_world = HighestAround(worst_place, surface);
  return WithObstacle(check, nearest);
}

std::optional<RollHazard> CheckGroundRoll(const Eigen::Vector3d& touchdown_in_world,
                                          double heading,
                                          const ClearanceSurface& surface,
                                          const Aircraft& aircraft) {
  for (const RollSample& sample : RollSamples(heading, surface, aircraft)) {
    const Eigen::Vector2d place = touchdown_in_world.head<2>() + sample.from_touchdown;
    const int row = surface.RowAt(place.y()), col = surface.ColAt(place.x());
    const int hazard = surface.IsInside(row, col) ? surface.hazard(row, col) : uchar{kUnseen};
    if (hazard != kFree) return RollHazard{place, sample.distance, hazard == kUnseen};
  }
  return std::nullopt;
}

ApproachProfile MakeProfile(const Approach& approach,
                            const ClearanceSurface& surface,
                            const Aircraft& aircraft,
                            const ApproachOptions& options) {
  const Corridor corridor =
      MakeCorridor(approach.heading, aircraft.path_half_width_m, surface.cell_size);
  const Eigen::Vector2d forward = DirectionOf(approach.heading);
  const double slope = approach.approach_height / approach.approach_distance;
  std::vector<double> distances =
      Steps(0.0, approach.approach_distance, AlongStep(surface, options));
  std::reverse(distances.begin(), distances.end());
  ApproachProfile profile;
  for (double distance : distances) {
    const Eigen::Vector2d place = approach.touchdown_in_world.head<2>() - distance * forward;
    const Slice slice = SliceAt(place, corridor, surface);
    profile.distance.push_back(distance);
    profile.path_height.push_back(approach.touchdown_in_world.z() + slope * distance);
    profile.terrain_height.push_back(slice.is_unseen ? std::numeric_limits<double>::quiet_NaN()
                                                     : slice.height);
  }
  return profile;
}

}  // namespace freelsd
