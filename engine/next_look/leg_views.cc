#include "engine/next_look/leg_views.h"

#include <algorithm>
#include <cmath>

namespace freelsd {
namespace {

// Rays nearer to the horizon than this are cut off there: ground that far away is not mapped.
const double kFarthestSlope = std::tan(RadFromDeg(60.0));

// Where a ray of the camera meets flat ground below, along and to the right of the aircraft.
Eigen::Vector2d OnGround(const Rig& rig, const Eigen::Vector2d& pixel, double height_m) {
  const Eigen::Vector3d ray_in_body =
      rig.body_from_camera.rotation * rig.camera.RayFromImage(pixel);
  const double down = std::max(ray_in_body.z(), 0.0);
  const double aside = ray_in_body.head<2>().norm();
  if (aside > kFarthestSlope * down) {
    return height_m * kFarthestSlope * ray_in_body.head<2>() / aside;
  }
  return height_m / down * ray_in_body.head<2>();
}

Polygon ShapeOnGround(const Rig& rig, double height_m) {
  constexpr int kNumPerSide = 4;
  Polygon places;
  for (int i = 0; i <= kNumPerSide; ++i) {
    for (int j = 0; j <= kNumPerSide; ++j) {
      if (i % kNumPerSide != 0 && j % kNumPerSide != 0) continue;
      const Eigen::Vector2d pixel((rig.camera.width_px - 1.0) * i / kNumPerSide,
                                  (rig.camera.height_px - 1.0) * j / kNumPerSide);
      places.push_back(OnGround(rig, pixel, height_m));
    }
  }
  return ConvexHull(places);
}

// First and last place of a convex polygon along a line of constant `right`; empty if first > last.
Eigen::Vector2d AlongAt(const Polygon& shape, double right) {
  Eigen::Vector2d along(1.0, -1.0);
  bool has_any = false;
  for (size_t i = 0; i < shape.size(); ++i) {
    const Eigen::Vector2d &a = shape[i], &b = shape[(i + 1) % shape.size()];
    if ((a.y() - right) * (b.y() - right) > 0.0 || a.y() == b.y()) continue;
    const double place = a.x() + (right - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
    along = has_any ? Eigen::Vector2d(std::min(along.x(), place), std::max(along.y(), place))
                    : Eigen::Vector2d(place, place);
    has_any = true;
  }
  return along;
}

}  // namespace

PhotoShape::PhotoShape(const Rig& rig, double height_above_ground_m) {
  const Polygon shape = ShapeOnGround(rig, height_above_ground_m);
  min_ = max_ = shape.front();
  for (const Eigen::Vector2d& corner : shape) {
    min_ = min_.cwiseMin(corner);
    max_ = max_.cwiseMax(corner);
  }
  for (double right = min_.y(); right <= max_.y(); right += kStepM) {
    along_.push_back(AlongAt(shape, right));
  }
}

int PhotoShape::NumViewsAt(const Eigen::Vector2d& along_right,
                           double length_m,
                           double spacing_m) const {
  const double step = (along_right.y() - min_.y()) / kStepM;
  if (step < 0.0 || step >= static_cast<double>(along_.size())) return 0;
  const Eigen::Vector2d& shown = along_[static_cast<size_t>(step)];
  if (shown.x() > shown.y()) return 0;
  const double last = std::floor(length_m / spacing_m);
  const double from = std::max(0.0, std::ceil((along_right.x() - shown.y()) / spacing_m));
  const double to = std::min(last, std::floor((along_right.x() - shown.x()) / spacing_m));
  return std::max(0, static_cast<int>(to - from) + 1);
}

LegViews ViewsOf(const LegLine& leg, const PhotoShape& shape, double spacing_m, const Grid& grid) {
  const double reach = shape.min().cwiseAbs().cwiseMax(shape.max().cwiseAbs()).norm();
  LegViews views;
  views.cells = grid.CellsAround({leg.from_in_world, leg.To()}, reach);
  views.num_views = cv::Mat1f(views.cells.size(), 0.0f);
  const Eigen::Vector2d ahead = DirectionOf(leg.heading), right(ahead.y(), -ahead.x());
  for (int row = 0; row < views.cells.height; ++row) {
    for (int col = 0; col < views.cells.width; ++col) {
      const Eigen::Vector2d place =
          grid.CellCenter(views.cells.y + row, views.cells.x + col) - leg.from_in_world;
      views.num_views(row, col) = static_cast<float>(
          shape.NumViewsAt({place.dot(ahead), place.dot(right)}, leg.length_m, spacing_m));
    }
  }
  return views;
}

}  // namespace freelsd
