#include "tests/evaluation/fields/ground_projection.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

namespace freelsd {
namespace {

// Longest piece of an outline's edge that is taken for straight on the ground.
constexpr double kMaxEdgePx = 40.0;
constexpr int kNumSteps = 40;
constexpr double kHeightToleranceM = 0.005;
// At a step in the map full steps of the iteration may jump to and fro for ever.
constexpr int kNumFullSteps = 5;

}  // namespace

GroundProjection::GroundProjection(const AdjustedBlock& block, GroundHeights heights)
    : block_(block), heights_(std::move(heights)) {
  for (size_t i = 0; i < block.views.size(); ++i) {
    if (!block.views[i].is_connected) continue;
    views_[std::filesystem::path(block.views[i].frame_id).stem().string()] = i;
  }
}

std::optional<size_t> GroundProjection::ViewOf(const std::string& photograph) const {
  const auto view = views_.find(photograph);
  return view == views_.end() ? std::nullopt : std::optional(view->second);
}

std::optional<Eigen::Vector3d> GroundProjection::GroundAt(size_t view,
                                                          const Eigen::Vector2d& point_in_image,
                                                          double raise) const {
  const Rigid3d& pose = block_.views[view].world_from_camera;
  const Eigen::Vector3d ray = pose.rotation * block_.CameraOf(view).RayFromImage(point_in_image);
  constexpr double kLeastDescent = 0.05;
  if (ray.z() > -kLeastDescent) return std::nullopt;
  double height = heights_.median() + raise;
  Eigen::Vector3d point = pose.translation;
  for (int step = 0; step < kNumSteps; ++step) {
    point = pose.translation + ray * ((height - pose.translation.z()) / ray.z());
    const double change = heights_.At(point.head<2>()) + raise - height;
    if (std::abs(change) < kHeightToleranceM) break;
    height += step < kNumFullSteps ? change : 0.5 * change;
  }
  if (height >= pose.translation.z()) return std::nullopt;
  return point;
}

std::optional<Polygon> GroundProjection::OnGround(const Outline& outline, double raise) const {
  const std::optional<size_t> view = ViewOf(outline.photograph);
  if (!view) return std::nullopt;
  Polygon polygon;
  const Polygon& corners = outline.corners_in_image;
  for (size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector2d edge = corners[(i + 1) % corners.size()] - corners[i];
    const int num_pieces = std::max(1, static_cast<int>(std::ceil(edge.norm() / kMaxEdgePx)));
    for (int piece = 0; piece < num_pieces; ++piece) {
      const auto point = GroundAt(*view, corners[i] + edge * (double(piece) / num_pieces), raise);
      if (!point) return std::nullopt;
      polygon.push_back(point->head<2>());
    }
  }
  return polygon;
}

}  // namespace freelsd
