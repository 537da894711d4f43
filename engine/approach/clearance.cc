#include "engine/approach/clearance.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

constexpr float kUnseenValue = std::numeric_limits<float>::quiet_NaN();
// Stands for "nothing seen" inside the morphological filters, which know no NaN.
constexpr float kBelowEverything = -1e6f;
constexpr double kMinGrassProbability = 0.5;
// Share of the path's height above touchdown that is wanted as clearance near the ground, where
// the whole margin would not fit under the path (spec 3.6).
constexpr double kShareOfPathHeight = 0.5;

float At(const cv::Mat1f& raster, const Grid& grid, const Eigen::Vector2d& place) {
  const std::optional<cv::Point> cell = grid.CellAt(place);
  return cell ? raster(*cell) : kUnseenValue;
}

// Disc of cells whose centres may come within the half-width of a path through the centre cell.
cv::Mat DiscKernel(double radius_m, double cell_size_m) {
  const int radius = std::max(0, static_cast<int>(std::ceil(radius_m / cell_size_m)));
  cv::Mat1b kernel(2 * radius + 1, 2 * radius + 1, uint8_t{0});
  const double reach = radius_m / cell_size_m + 0.5;
  for (int row = -radius; row <= radius; ++row) {
    for (int col = -radius; col <= radius; ++col) {
      if (std::hypot(row, col) <= reach) kernel(row + radius, col + radius) = 1;
    }
  }
  return kernel;
}

// What a slice across the path holds.
struct Slice {
  bool is_seen = true;
  float highest = kUnseenValue;
  Eigen::Vector2d place = Eigen::Vector2d::Zero();
};

Slice HighestAcross(const ObstacleSurface& surface,
                    const Eigen::Vector2d& center,
                    const Eigen::Vector2d& across,
                    double half_width) {
  const double step = 0.5 * surface.grid.cell_size_m;
  const int num_steps = std::max(1, static_cast<int>(std::ceil(half_width / step)));
  Slice slice;
  for (int i = -num_steps; i <= num_steps; ++i) {
    const Eigen::Vector2d place = center + across * (half_width * i / num_steps);
    const float height = At(surface.height, surface.grid, place);
    if (std::isnan(height)) {
      if (slice.is_seen) slice.place = place;
      slice.is_seen = false;
    } else if (std::isnan(slice.highest) || height > slice.highest) {
      slice.highest = height;
      if (slice.is_seen) slice.place = place;
    }
  }
  return slice;
}

}  // namespace

ObstacleSurface MakeObstacleSurface(const ElevationMap& map,
                                    const HazardLayers& hazards,
                                    const Aircraft& aircraft,
                                    const ApproachOptions& options) {
  ObstacleSurface surface;
  surface.grid = map.grid;
  surface.height = map.upper.clone();
  cv::Mat1f seen(map.upper.size());
  cv::Mat1b unseen(map.upper.size());
  for (int row = 0; row < seen.rows; ++row) {
    for (int col = 0; col < seen.cols; ++col) {
      float& height = surface.height(row, col);
      const float grass = hazards.grass(row, col);
      const bool is_clear_class = !std::isnan(grass) && grass >= kMinGrassProbability;
      if (!is_clear_class) height += static_cast<float>(options.unclear_height_allowance_m);
      unseen(row, col) = std::isnan(height) ? 1 : 0;
      seen(row, col) = std::isnan(height) ? kBelowEverything : height;
    }
  }
  const cv::Mat kernel = DiscKernel(aircraft.path_half_width_m, map.grid.cell_size_m);
  cv::dilate(seen,
             surface.dilated_seen,
             kernel,
             {-1, -1},
             1,
             cv::BORDER_CONSTANT,
             cv::Scalar(kBelowEverything));
  cv::Mat1b any_unseen;
  cv::dilate(unseen, any_unseen, kernel, {-1, -1}, 1, cv::BORDER_CONSTANT, cv::Scalar(1));
  surface.dilated_seen.setTo(kUnseenValue, surface.dilated_seen <= kBelowEverything);
  surface.dilated = surface.dilated_seen.clone();
  surface.dilated.setTo(kUnseenValue, any_unseen);
  return surface;
}

FinalCheck CheckFinal(const ObstacleSurface& surface,
                      const Approach& approach,
                      const Aircraft& aircraft,
                      const ApproachOptions& options) {
  const Eigen::Vector2d travel = DirectionOf(approach.heading);
  const Eigen::Vector2d across(-travel.y(), travel.x());
  const Eigen::Vector2d touchdown = approach.touchdown_in_world.head<2>();
  const int num_steps =
      std::max(1, static_cast<int>(std::ceil(approach.approach_distance / options.path_step_m)));
  FinalCheck check;
  check.min_clearance = std::numeric_limits<double>::infinity();
  for (int i = 0; i <= num_steps; ++i) {
    const double distance = approach.approach_distance * i / num_steps;
    const double above = approach.approach_height * i / num_steps;
    const Eigen::Vector2d center = touchdown - travel * distance;
    const Slice slice = HighestAcross(surface, center, across, aircraft.path_half_width_m);
    const double path_height = approach.touchdown_in_world.z() + above;
    check.profile.distance.push_back(distance);
    check.profile.path_height.push_back(path_height);
    check.profile.terrain_height.push_back(
        slice.is_seen ? slice.highest : std::numeric_limits<double>::quiet_NaN());
    if (distance < aircraft.touchdown_uncertainty_m) continue;
    const double wanted = std::min(aircraft.safety_margin_m, kShareOfPathHeight * above);
    const double clearance = path_height - slice.highest;
    const bool is_blocked = !std::isnan(slice.highest) && clearance < wanted;
    if (!std::isnan(slice.highest)) {
      check.min_clearance = std::min(check.min_clearance, clearance);
      check.worst_shortage = std::max(check.worst_shortage, wanted - clearance);
    }
    if (check.reason || (slice.is_seen && !is_blocked)) continue;
    check.reason = is_blocked ? RejectReason::kApproachBlocked : RejectReason::kApproachUnseen;
    check.distance = distance;
    check.place_in_world = slice.place.homogeneous();
    check.place_in_world.z() = std::isnan(slice.highest) ? path_height : slice.highest;
  }
  std::reverse(check.profile.distance.begin(), check.profile.distance.end());
  std::reverse(check.profile.path_height.begin(), check.profile.path_height.end());
  std::reverse(check.profile.terrain_height.begin(), check.profile.terrain_height.end());
  return check;
}

CircleCheck CheckCircle(const ObstacleSurface& surface,
                        const Approach& approach,
                        LoiterDirection direction,
                        const Aircraft& aircraft,
                        const ApproachOptions& options) {
  const Eigen::Vector3d center = LoiterCenter(approach, direction);
  const Eigen::Vector2d from_center = (approach.approach_start_in_world - center).head<2>();
  const double length = 2.0 * kPi * approach.loiter_radius;
  const int num_steps = std::max(8, static_cast<int>(std::ceil(length / options.path_step_m)));
  CircleCheck check;
  check.min_clearance = std::numeric_limits<double>::infinity();
  int num_unseen = 0;
  for (int i = 0; i < num_steps; ++i) {
    const Eigen::Rotation2Dd rotation(2.0 * kPi * i / num_steps);
    const Eigen::Vector2d place = center.head<2>() + rotation * from_center;
    if (std::isnan(At(surface.dilated, surface.grid, place))) ++num_unseen;
    const float highest = At(surface.dilated_seen, surface.grid, place);
    if (std::isnan(highest)) continue;
    const double clearance = center.z() - highest;
    if (clearance < check.min_clearance) {
      check.min_clearance = clearance;
      check.obstacle_in_world = {place.x(), place.y(), highest};
    }
  }
  check.is_blocked = check.min_clearance < aircraft.safety_margin_m;
  check.unseen_ratio = static_cast<double>(num_unseen) / num_steps;
  return check;
}

std::optional<Eigen::Vector3d> HazardOnStrip(const ElevationMap& map,
                                             const HazardLayers& hazards,
                                             const Leg& leg,
                                             const Aircraft& aircraft) {
  if (aircraft.ground_roll_m <= 0.0) return std::nullopt;
  const Eigen::Vector2d travel = DirectionOf(leg.heading);
  const Eigen::Vector2d across(-travel.y(), travel.x());
  const double step = 0.5 * map.grid.cell_size_m;
  const int num_along = static_cast<int>(std::ceil(aircraft.ground_roll_m / step));
  const int num_across =
      std::max(1, static_cast<int>(std::ceil(aircraft.path_half_width_m / step)));
  for (int i = 0; i <= num_along; ++i) {
    for (int j = -num_across; j <= num_across; ++j) {
      const Eigen::Vector2d place = leg.touchdown_in_world.head<2>() +
                                    travel * (aircraft.ground_roll_m * i / num_along) +
                                    across * (aircraft.path_half_width_m * j / num_across);
      const std::optional<cv::Point> cell = map.grid.CellAt(place);
      if (cell && hazards.hazard(*cell) == kFree) continue;
      const float height = cell ? map.upper(*cell) : kUnseenValue;
      return Eigen::Vector3d(
          place.x(), place.y(), std::isnan(height) ? leg.touchdown_in_world.z() : height);
    }
  }
  return std::nullopt;
}

}  // namespace freelsd
