#include "engine/tracks/ground/overlap.h"

#include <algorithm>

#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

// Corners of the photograph's footprint on level ground; empty if one is near the horizon.
std::vector<cv::Point2f> FootprintCorners(const View& view, const Camera& camera) {
  constexpr double kMinViewDescent = 0.2;
  const double right = camera.width_px - 1.0, bottom = camera.height_px - 1.0;
  std::vector<cv::Point2f> corners;
  for (const Eigen::Vector2d& pixel : {Eigen::Vector2d(0.0, 0.0),
                                       Eigen::Vector2d(right, 0.0),
                                       Eigen::Vector2d(right, bottom),
                                       Eigen::Vector2d(0.0, bottom)}) {
    const Eigen::Vector3d ray = view.world_from_camera.rotation * camera.RayFromImage(pixel);
    if (ray.z() > -kMinViewDescent) return {};
    const Eigen::Vector2d place = view.world_from_camera.translation.head<2>() +
                                  ray.head<2>() * (view.height_above_ground / -ray.z());
    corners.emplace_back(static_cast<float>(place.x()), static_cast<float>(place.y()));
  }
  return corners;
}

}  // namespace

std::vector<ViewPair> OverlappingPairs(const std::vector<View>& views,
                                       const Camera& camera,
                                       double min_overlap_ratio) {
  std::vector<std::vector<cv::Point2f>> footprints;
  footprints.reserve(views.size());
  for (const View& view : views)
    footprints.push_back(FootprintCorners(view, camera.With(view.readout)));
  std::vector<ViewPair> pairs;
  for (size_t i = 0; i < views.size(); ++i) {
    for (size_t j = i + 1; j < views.size(); ++j) {
      if (footprints[i].empty() || footprints[j].empty()) continue;
      std::vector<cv::Point2f> common;
      const double area = cv::intersectConvexConvex(footprints[i], footprints[j], common);
      const double smaller =
          std::min(cv::contourArea(footprints[i]), cv::contourArea(footprints[j]));
      if (area > min_overlap_ratio * smaller) pairs.push_back({i, j, area / smaller});
    }
  }
  return pairs;
}

}  // namespace freelsd
