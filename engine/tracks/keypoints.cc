#include "engine/tracks/keypoints.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

namespace freelsd {
namespace {

// Lucas-Kanade: the window sees texture of a meadow, the pyramid reaches displacements of about
// ten windows.
const cv::Size kWindow(17, 17);
constexpr int kNumPyramidLevels = 4;
constexpr int kMaxNumIterations = 10;
constexpr double kIterationTolerancePx = 0.03;
// Corner quality relative to the best of the image; low, because grass beside a roof still counts.
constexpr double kCornerQuality = 0.002;
// Grass and dark frames have little contrast; OpenCV's default is 0.04.
constexpr double kSiftContrast = 0.015;
constexpr double kSiftEdgeRatio = 10.0;
constexpr double kSiftSigma = 1.6;
constexpr int kSiftLayersPerOctave = 3;
// Cells over which keypoints are spread, per axis.
constexpr int kNumGridCells = 8;
// Lowe's ratio of the nearest to the second nearest distance.
constexpr double kMaxDistanceRatio = 0.85;
// Of root descriptors of unrelated points, about.
constexpr float kUnrelatedCosine = 0.75F;
// Root-SIFT entries are in [0, 1] and rarely above one half: stored as bytes.
constexpr double kDescriptorScale = 400.0;

cv::Mat GreyOf(const cv::Mat& image) {
  if (image.channels() == 1) return image.clone();
  cv::Mat grey;
  cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  return grey;
}

// Best keypoints of every cell of a grid, so that one bush does not take them all.
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

cv::Mat UnitRows(const cv::Mat& bytes) {
  cv::Mat unit;
  bytes.convertTo(unit, CV_32F);
  for (int row = 0; row < unit.rows; ++row) {
    cv::Mat line = unit.row(row);
    line /= std::max(cv::norm(line), 1.0);
  }
  return unit;
}

// Nearest per row, by cosine; -1 where the second nearest is about as near. Internal sentinel.
std::vector<int> NearestPerRow(const Eigen::MatrixXf& cosines) {
  std::vector<int> nearest(cosines.cols(), -1);
  for (Eigen::Index col = 0; col < cosines.cols(); ++col) {
    float best = -1.0F, second = -1.0F;
    int best_row = -1;
    for (Eigen::Index row = 0; row < cosines.rows(); ++row) {
      const float cosine = cosines(row, col);
      if (cosine > best) {
        second = best;
        best = cosine;
        best_row = static_cast<int>(row);
      } else if (cosine > second) {
        second = cosine;
      }
    }
    // Squared distance of unit vectors is 2 - 2 cos.
    const double limit = kMaxDistanceRatio * kMaxDistanceRatio * (1.0 - second);
    if (1.0 - best < limit) nearest[col] = best_row;
  }
  return nearest;
}

// The two most similar so far. A second is assumed from the start: nearby there may be none, and
// points that have nothing to do with one another are this similar.
struct BestTwo {
  int index = -1;
  float best = kUnrelatedCosine;
  float second = kUnrelatedCosine;

  void Offer(int candidate, float cosine) {
    if (cosine > best) {
      second = std::exchange(best, cosine);
      index = candidate;
    } else {
      second = std::max(second, cosine);
    }
  }
  bool IsClear() const {
    return index >= 0 && 1.0 - best < kMaxDistanceRatio * kMaxDistanceRatio * (1.0 - second);
  }
};

// Points by square cells as wide as a radius.
using Buckets = std::map<std::pair<int, int>, std::vector<int>>;

std::pair<int, int> CellOf(const Eigen::Vector2d& point, double width) {
  return {static_cast<int>(std::floor(point.x() / width)),
          static_cast<int>(std::floor(point.y() / width))};
}

// Of the nine cells about a place.
std::vector<int> Nearby(const Buckets& buckets, const std::pair<int, int>& cell) {
  std::vector<int> nearby;
  for (int x = cell.first - 1; x <= cell.first + 1; ++x) {
    for (int y = cell.second - 1; y <= cell.second + 1; ++y) {
      const auto bucket = buckets.find({x, y});
      if (bucket == buckets.end()) continue;
      nearby.insert(nearby.end(), bucket->second.begin(), bucket->second.end());
    }
  }
  return nearby;
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
                                         const TracksOptions& options) {
  const int missing = options.max_num_corners - static_cast<int>(existing.size());
  if (missing <= 0) return {};
  // A quarter of the mean spacing keeps corners apart but lets textured patches be used.
  const double area = static_cast<double>(image.grey.total());
  const double spacing = 0.5 * std::sqrt(area / options.max_num_corners);
  cv::Mat mask(image.grey.size(), CV_8U, cv::Scalar(255));
  for (const Eigen::Vector2d& point : existing) {
    cv::circle(mask, image.ReducedFromFull(point), static_cast<int>(spacing), 0, cv::FILLED);
  }
  std::vector<cv::Point2f> corners;
  cv::goodFeaturesToTrack(image.grey, corners, missing, kCornerQuality, spacing, mask);
  std::vector<Eigen::Vector2d> points;
  for (const cv::Point2f& corner : corners) points.push_back(image.FullFromReduced(corner));
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

std::vector<IndexPair> MatchDescriptors(const cv::Mat& a, const cv::Mat& b) {
  if (a.rows < 2 || b.rows < 2) return {};
  using Rows =
      Eigen::Map<const Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>;
  const cv::Mat unit_a = UnitRows(a), unit_b = UnitRows(b);
  const Rows rows_a(unit_a.ptr<float>(), unit_a.rows, unit_a.cols);
  const Rows rows_b(unit_b.ptr<float>(), unit_b.rows, unit_b.cols);
  const Eigen::MatrixXf cosines = rows_a * rows_b.transpose();
  const std::vector<int> a_of_b = NearestPerRow(cosines);
  const std::vector<int> b_of_a = NearestPerRow(cosines.transpose());
  std::vector<IndexPair> matches;
  for (int i = 0; i < a.rows; ++i) {
    const int j = b_of_a[i];
    if (j >= 0 && a_of_b[j] == i) matches.push_back({i, j});
  }
  return matches;
}

std::vector<IndexPair> MatchDescriptorsNear(const DescribedPoints& a,
                                            const DescribedPoints& b,
                                            double radius) {
  if (a.points.empty() || b.points.empty()) return {};
  const cv::Mat1f unit_a = UnitRows(a.descriptors), unit_b = UnitRows(b.descriptors);
  Buckets buckets;
  for (size_t j = 0; j < b.points.size(); ++j) {
    buckets[CellOf(b.points[j], radius)].push_back(static_cast<int>(j));
  }
  std::vector<BestTwo> of_a(a.points.size()), of_b(b.points.size());
  for (size_t i = 0; i < a.points.size(); ++i) {
    const Eigen::Map<const Eigen::VectorXf> row_a(unit_a[static_cast<int>(i)], unit_a.cols);
    for (const int j : Nearby(buckets, CellOf(a.points[i], radius))) {
      if ((a.points[i] - b.points[static_cast<size_t>(j)]).norm() > radius) continue;
      const float cosine = row_a.dot(Eigen::Map<const Eigen::VectorXf>(unit_b[j], unit_b.cols));
      of_a[i].Offer(j, cosine);
      of_b[static_cast<size_t>(j)].Offer(static_cast<int>(i), cosine);
    }
  }
  std::vector<IndexPair> matches;
  for (size_t i = 0; i < of_a.size(); ++i) {
    if (!of_a[i].IsClear()) continue;
    const BestTwo& back = of_b[static_cast<size_t>(of_a[i].index)];
    if (back.index == static_cast<int>(i) && back.IsClear()) {
      matches.push_back({static_cast<int>(i), of_a[i].index});
    }
  }
  return matches;
}

}  // namespace freelsd
