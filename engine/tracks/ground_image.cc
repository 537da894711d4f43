#include "engine/tracks/ground_image.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "engine/tracks/keypoints.h"

namespace freelsd {
namespace {

// Rays flatter than this see too little of the ground.
constexpr double kMinDescent = 0.5;
// Where each pixel comes from is computed at every n-th and interpolated between.
constexpr int kStepPx = 16;
// A pixel that no camera has.
constexpr float kNowhere = -1e4F;

// Bounds on the ground of what the photograph shows; empty when it looks at the sky.
struct Footprint {
  Eigen::Vector2d min = Eigen::Vector2d::Constant(1e9);
  Eigen::Vector2d max = Eigen::Vector2d::Constant(-1e9);
};

Footprint FootprintOf(const View& view, const Camera& camera) {
  constexpr int kNumSteps = 4;
  Footprint footprint;
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

// Pixel of the reduced photograph for every n-th pixel of the ground image.
cv::Mat2f CoarseMap(const GroundImage& ground,
                    const cv::Size& size,
                    const View& view,
                    const Camera& camera,
                    const TrackingImage& reduced) {
  const Rigid3d camera_from_world = Inverse(view.world_from_camera);
  cv::Mat2f map(size.height / kStepPx + 2, size.width / kStepPx + 2);
  for (int row = 0; row < map.rows; ++row) {
    for (int col = 0; col < map.cols; ++col) {
      const Eigen::Vector3d place = ground.WorldFromPixel(
          {static_cast<double>(col * kStepPx), static_cast<double>(row * kStepPx)});
      const auto pixel = camera.ImageFromCamera(camera_from_world * place);
      map(row, col) = cv::Vec2f(kNowhere, kNowhere);
      if (!pixel) continue;
      const cv::Point2f there = reduced.ReducedFromFull(*pixel);
      map(row, col) = cv::Vec2f(there.x, there.y);
    }
  }
  return map;
}

cv::Mat2f FineMap(const cv::Mat2f& coarse, const cv::Size& size) {
  cv::Mat2f fine(size);
  for (int row = 0; row < size.height; ++row) {
    const int i = row / kStepPx;
    const float down = static_cast<float>(row % kStepPx) / kStepPx;
    for (int col = 0; col < size.width; ++col) {
      const int j = col / kStepPx;
      const float right = static_cast<float>(col % kStepPx) / kStepPx;
      const cv::Vec2f above = coarse(i, j) * (1.0F - right) + coarse(i, j + 1) * right;
      const cv::Vec2f below = coarse(i + 1, j) * (1.0F - right) + coarse(i + 1, j + 1) * right;
      fine(row, col) = above * (1.0F - down) + below * down;
    }
  }
  return fine;
}

}  // namespace

GroundImage SeenFromAbove(const View& view,
                          const Camera& camera,
                          const cv::Mat& image,
                          int width_px) {
  TracksOptions at_width;
  at_width.matching_width_px = width_px;
  const TrackingImage reduced = ReduceForTracking(image, at_width);
  const Footprint footprint = FootprintOf(view, camera);
  GroundImage ground;
  ground.ground_z = view.world_from_camera.translation.z() - view.height_above_ground;
  ground.pixel_m = view.height_above_ground / (camera.MeanFocalPx() * reduced.scale);
  ground.north_west = {footprint.min.x(), footprint.max.y()};
  // A tilted camera sees far: not more of it than twice the photograph's own size.
  const Eigen::Vector2d extent =
      ((footprint.max - footprint.min) / ground.pixel_m).cwiseMin(2.0 * reduced.grey.cols);
  const cv::Size size(static_cast<int>(extent.x()), static_cast<int>(extent.y()));
  if (size.width < 2 * kStepPx || size.height < 2 * kStepPx) return ground;
  const cv::Mat2f map = FineMap(CoarseMap(ground, size, view, camera, reduced), size);
  cv::remap(reduced.grey, ground.grey, map, cv::noArray(), cv::INTER_LINEAR);
  return ground;
}

}  // namespace freelsd
