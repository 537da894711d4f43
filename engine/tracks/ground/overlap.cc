#include "engine/tracks/ground/overlap.h"

#include <algorithm>

#include <opencv2/imgproc.hpp>

#include "engine/footprint/footprint.h"

namespace freelsd {
namespace {

std::vector<cv::Point2f> FootprintCorners(const View& view, const Camera& camera) {
  std::vector<cv::Point2f> corners;
  for (const Eigen::Vector2d& place :
       CornersOnGround(camera, view.world_from_camera, view.height_above_ground)) {
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
