#include "engine/tracks/ground/ground_image.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "engine/geometry/geometry.h"
#include "engine/tracks/keypoints.h"

namespace freelsd {
namespace {

// Flatter rays see too little of the ground.
constexpr double kMinDescent = 0.5;
// The ground is far away, so distortion is nearly linear over this many pixels.
constexpr int kNodeSpacingPx = 16;

// Bounds on the ground of what the photograph shows; empty when it looks at the sky.
struct GroundBox {
  Eigen::Vector2d min = Eigen::Vector2d::Constant(1e9);
  Eigen::Vector2d max = Eigen::Vector2d::Constant(-1e9);
};

GroundBox BoxOf(const View& view, const Camera& camera) {
  constexpr int kNumSteps = 4;
  GroundBox footprint;
  for (int row = 0; row <= kNumSteps; ++row) {
    for (int col = 0; col <= kNumSteps; ++col) {
      const Eigen::Vector2d pixel(col * (camera.width_px - 1.0) / kNumSteps,
                                  row * (camera.height_px - 1.0) / kNumSteps);
      const Eigen::Vector3d ray = view.world_from_camera.rotation * camera.RayFromImage(pixel);
      if (ray.z() > -kMinDescent) continue;
      const Eigen::Vector2d place = view.world_from_camera.translation.head<2>() +
                                    ray.head<2>() * (view.height_above_ground / -ray.z());
      footprint.min = footprint.min.cwiseMin(place);
      footprint.max = footprint.max.cwiseMax(place);
    }
  }
  return footprint;
}

// Where the reduced photograph shows each pixel of the ground image.
cv::Mat2f TableOf(const GroundImage& ground,
                  const cv::Size& size,
                  const View& view,
                  const Camera& camera,
                  const TrackingImage& reduced) {
  const Rigid3d camera_from_world = Inverse(view.world_from_camera);
  return RemapTable(
      size, kNodeSpacingPx, [&](double col, double row) -> std::optional<Eigen::Vector2d> {
        const auto pixel =
            camera.ImageFromCamera(camera_from_world * ground.WorldFromPixel({col, row}));
        if (!pixel) return std::nullopt;
        const cv::Point2f there = reduced.ReducedFromFull(*pixel);
        return Eigen::Vector2d(there.x, there.y);
      });
}

}  // namespace

GroundImage SeenFromAbove(const View& view,
                          const Camera& camera,
                          const cv::Mat& image,
                          int width_px) {
  TracksOptions at_width;
  at_width.matching_width_px = width_px;
  const TrackingImage reduced = ReduceForTracking(image, at_width);
  const GroundBox footprint = BoxOf(view, camera);
  GroundImage ground;
  ground.ground_z = view.world_from_camera.translation.z() - view.height_above_ground;
  ground.pixel_m = view.height_above_ground / (camera.MeanFocalPx() * reduced.scale);
  ground.north_west = {footprint.min.x(), footprint.max.y()};
  // A tilted camera sees far. The extent is limited to twice the photograph's own size.
  const Eigen::Vector2d extent =
      ((footprint.max - footprint.min) / ground.pixel_m).cwiseMin(2.0 * reduced.grey.cols);
  const cv::Size size(static_cast<int>(extent.x()), static_cast<int>(extent.y()));
  if (size.width < 2 * kNodeSpacingPx || size.height < 2 * kNodeSpacingPx) return ground;
  const cv::Mat2f table = TableOf(ground, size, view, camera, reduced);
  cv::remap(reduced.grey, ground.grey, table, cv::noArray(), cv::INTER_LINEAR);
  return ground;
}

}  // namespace freelsd
