#include "engine/tracks/keypoints.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "engine/tracks/corners.h"

namespace freelsd {
namespace {

// Lucas-Kanade: the window covers enough texture of a meadow, and the pyramid allows displacements
// of about ten windows.
const cv::Size kWindow(17, 17);
constexpr int kNumPyramidLevels = 4;
constexpr int kMaxNumIterations = 10;
constexpr double kIterationTolerancePx = 0.03;
// Corner quality relative to the best in the image. Low, so that grass beside a roof counts.
constexpr double kCornerQuality = 0.002;
// Grass and dark frames have little contrast; OpenCV's default is 0.04.
constexpr double kSiftContrast = 0.015;
constexpr double kSiftEdgeRatio = 10.0;
constexpr double kSiftSigma = 1.6;
constexpr int kSiftLayersPerOctave = 3;
// Cells per axis over which keypoints are spread.
constexpr int kNumGridCells = 8;
// Root-SIFT entries are in [0, 1] and rarely above one half. Scaled to be stored as bytes.
constexpr double kDescriptorScale = 400.0;

cv::Mat GreyOf(const cv::Mat& image) {
  if (image.channels() == 1) return image.clone();
  cv::Mat grey;
  cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  return grey;
}

// Best keypoints of every cell of a grid, so that they cover the image.
std::vector<cv::KeyPoint> Spread(std::vector<cv::KeyPoint> keypoints,
                                 cv::Size size,
                                 int max_count) {
  if (static_cast<int>(keypoints.size()) <= max_count) return keypoints;
  std::stable_sort(keypoints.begin(), keypoints.end(), [](const auto& a, const auto& b) {
    return a.response > b.response;
  });
  std::vector<int> filled(kNumGridCells * kNumGridCells, 0);
  const int share = max_count / (kNumGridCells * kNumGridCells) + 1;
  std::vector<cv::KeyPoint> chosen, spare;
  for (const cv::KeyPoint& keypoint : keypoints) {
    const int col = std::clamp(
        static_cast<int>(keypoint.pt.x * kNumGridCells) / size.width, 0, kNumGridCells - 1);
    const int row = std::clamp(
        static_cast<int>(keypoint.pt.y * kNumGridCells) / size.height, 0, kNumGridCells - 1);
    const bool has_room = filled[row * kNumGridCells + col]++ < share;
    (has_room ? chosen : spare).push_back(keypoint);
  }
  for (const cv::KeyPoint& keypoint : spare) {
    if (static_cast<int>(chosen.size()) >= max_count) break;
    chosen.push_back(keypoint);
  }
  if (static_cast<int>(chosen.size()) > max_count) chosen.resize(max_count);
  return chosen;
}

// Hellinger kernel: square root of the L1-normalised descriptor.
cv::Mat RootDescriptors(const cv::Mat& descriptors) {
  cv::Mat root(descriptors.rows, descriptors.cols, CV_8U);
  for (int row = 0; row < descriptors.rows; ++row) {
    const double sum = std::max(cv::norm(descriptors.row(row), cv::NORM_L1), 1e-6);
    for (int col = 0; col < descriptors.cols; ++col) {
      const double entry = std::sqrt(descriptors.at<float>(row, col) / sum);
      root.at<uchar>(row, col) = cv::saturate_cast<uchar>(entry * kDescriptorScale);
    }
  }
  return root;
}

}  // namespace

Eigen::Vector2d TrackingImage::FullFromReduced(const cv::Point2f& point) const {
  return {(point.x + 0.5) / scale - 0.5, (point.y + 0.5) / scale - 0.5};
}

cv::Point2f TrackingImage::ReducedFromFull(const Eigen::Vector2d& point) const {
  return {static_cast<float>((point.x() + 0.5) * scale - 0.5),
          static_cast<float>((point.y() + 0.5) * scale - 0.5)};
}

TrackingImage ReduceForTracking(const cv::Mat& image, const TracksOptions& options) {
  TrackingImage reduced;
  reduced.scale = std::min(1.0, static_cast<double>(options.matching_width_px) / image.cols);
  if (reduced.scale == 1.0) {
    reduced.grey = GreyOf(image);
    return reduced;
  }
  cv::Mat small;
  const cv::Size size(options.matching_width_px,
                      std::max(1, static_cast<int>(std::lround(image.rows * reduced.scale))));
  cv::resize(image, small, size, 0.0, 0.0, cv::INTER_AREA);
  reduced.grey = GreyOf(small);
  return reduced;
}

std::vector<Eigen::Vector2d> FindCorners(const TrackingImage& image,
                                         const std::vector<Eigen::Vector2d>& existing,
                                         int max_count) {
  const int missing = max_count - static_cast<int>(existing.size());
  if (missing <= 0) return {};
  // A quarter of the mean spacing separates corners and still uses textured patches.
  const double area = static_cast<double>(image.grey.total());
  const double spacing = 0.5 * std::sqrt(area / max_count);
  cv::Mat mask(image.grey.size(), CV_8U, cv::Scalar(255));
  for (const Eigen::Vector2d& point : existing) {
    cv::circle(mask, image.ReducedFromFull(point), static_cast<int>(spacing), 0, cv::FILLED);
  }
  std::vector<Eigen::Vector2d> points;
  for (const cv::Point& corner :
       StrongestCorners(image.grey, {mask, missing, kCornerQuality, spacing})) {
    points.push_back(image.FullFromReduced(corner));
  }
  return points;
}

TrackingImage WithPyramid(TrackingImage image) {
  if (image.pyramid.empty()) {
    cv::buildOpticalFlowPyramid(image.grey, image.pyramid, kWindow, kNumPyramidLevels);
  }
  return image;
}

std::vector<std::optional<Eigen::Vector2d>> FollowCorners(
    const TrackingImage& from,
    const TrackingImage& to,
    const std::vector<Eigen::Vector2d>& points,
    const std::vector<Eigen::Vector2d>& guesses,
    const TracksOptions& options) {
  std::vector<std::optional<Eigen::Vector2d>> followed(points.size());
  if (points.empty()) return followed;
  std::vector<cv::Point2f> start, there, back;
  for (const Eigen::Vector2d& point : points) start.push_back(from.ReducedFromFull(point));
  for (const Eigen::Vector2d& guess : guesses) there.push_back(to.ReducedFromFull(guess));
  const int flags = guesses.empty() ? 0 : cv::OPTFLOW_USE_INITIAL_FLOW;
  const cv::TermCriteria criteria(
      cv::TermCriteria::COUNT + cv::TermCriteria::EPS, kMaxNumIterations, kIterationTolerancePx);
  std::vector<uchar> found, found_back;
  cv::calcOpticalFlowPyrLK(from.pyramid,
                           to.pyramid,
                           start,
                           there,
                           found,
                           cv::noArray(),
                           kWindow,
                           kNumPyramidLevels,
                           criteria,
                           flags);
  back = start;
  cv::calcOpticalFlowPyrLK(to.pyramid,
                           from.pyramid,
                           there,
                           back,
                           found_back,
                           cv::noArray(),
                           kWindow,
                           kNumPyramidLevels,
                           criteria,
                           cv::OPTFLOW_USE_INITIAL_FLOW);
  const cv::Rect2f inside(
      0.0F, 0.0F, static_cast<float>(to.grey.cols - 1), static_cast<float>(to.grey.rows - 1));
  for (size_t i = 0; i < points.size(); ++i) {
    if (!found[i] || !found_back[i] || !inside.contains(there[i])) continue;
    if (cv::norm(back[i] - start[i]) > options.max_forward_backward_error_px) continue;
    followed[i] = to.FullFromReduced(there[i]);
  }
  return followed;
}

DescribedPoints DescribeKeypoints(const TrackingImage& image, const TracksOptions& options) {
  const cv::Ptr<cv::SIFT> sift =
      cv::SIFT::create(0, kSiftLayersPerOctave, kSiftContrast, kSiftEdgeRatio, kSiftSigma);
  std::vector<cv::KeyPoint> keypoints;
  sift->detect(image.grey, keypoints);
  keypoints = Spread(std::move(keypoints), image.grey.size(), options.max_num_keypoints);
  DescribedPoints described;
  if (keypoints.empty()) return described;
  cv::Mat descriptors;
  sift->compute(image.grey, keypoints, descriptors);
  described.descriptors = RootDescriptors(descriptors);
  for (const cv::KeyPoint& keypoint : keypoints) {
    described.points.push_back(image.FullFromReduced(keypoint.pt));
  }
  return described;
}

}  // namespace freelsd
