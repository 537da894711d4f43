#include "engine/stereo/place_counts.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <opencv2/imgproc.hpp>

#include "engine/footprint/footprint.h"

namespace freelsd {
namespace {

constexpr double kMinCellM = 4.0;
constexpr double kMaxNumCells = 1e6;

}  // namespace

PlaceCounts::PlaceCounts(const AdjustedBlock& block) {
  std::vector<std::vector<Eigen::Vector2d>> corners;
  Eigen::AlignedBox2d box;
  for (size_t i = 0; i < block.views.size(); ++i) {
    const AdjustedView& view = block.views[i];
    corners.emplace_back();
    if (!view.is_connected) continue;
    corners.back() =
        CornersOnGround(block.CameraOf(i), view.world_from_camera, view.height_above_ground);
    for (const Eigen::Vector2d& corner : corners.back()) box.extend(corner);
  }
  footprints_.resize(corners.size());
  if (box.isEmpty()) return;
  const double cell_m = std::max(kMinCellM, std::sqrt(box.sizes().prod() / kMaxNumCells));
  for (size_t i = 0; i < corners.size(); ++i) {
    for (const Eigen::Vector2d& corner : corners[i]) {
      const Eigen::Vector2f cell = ((corner - box.min()) / cell_m).cast<float>();
      footprints_[i].emplace_back(cell.x(), cell.y());
    }
  }
  counts_.create(static_cast<int>(box.sizes().y() / cell_m) + 2,
                 static_cast<int>(box.sizes().x() / cell_m) + 2);
  counts_.setTo(0);
}

PlaceCounts::Overlap PlaceCounts::OverlapOf(const StereoPair& pair) const {
  if (footprints_[pair.left].empty() || footprints_[pair.right].empty()) return {};
  std::vector<cv::Point2f> common;
  cv::intersectConvexConvex(footprints_[pair.left], footprints_[pair.right], common);
  if (common.size() < 3) return {};
  std::vector<cv::Point> corners;
  corners.reserve(common.size());
  for (const cv::Point2f& corner : common) {
    corners.emplace_back(cvRound(corner.x), cvRound(corner.y));
  }
  Overlap overlap;
  overlap.part = cv::boundingRect(corners) & cv::Rect({}, counts_.size());
  overlap.mask = cv::Mat1b(overlap.part.size(), static_cast<uint8_t>(0));
  for (cv::Point& corner : corners) corner -= overlap.part.tl();
  if (!overlap.mask.empty()) cv::fillConvexPoly(overlap.mask, corners, 255);
  return overlap;
}

void PlaceCounts::Add(const StereoPair& pair) {
  const Overlap overlap = OverlapOf(pair);
  if (overlap.mask.empty()) return;
  cv::Mat1b counts = counts_(overlap.part);
  cv::add(counts, 1, counts, overlap.mask);
}

double PlaceCounts::NeededRatio(const StereoPair& pair, int num_pairs) const {
  const Overlap overlap = OverlapOf(pair);
  if (overlap.mask.empty()) return 0.0;
  const cv::Mat needing = (counts_(overlap.part) < num_pairs) & overlap.mask;
  return cv::countNonZero(needing) / std::max(1.0, 1.0 * cv::countNonZero(overlap.mask));
}

}  // namespace freelsd
