#include "engine/tracks/verification.h"

#include <algorithm>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <opencv2/calib3d.hpp>

namespace freelsd {
namespace {

constexpr int kMinSampleSize = 8;
constexpr int kRandomState = 20260101;
constexpr int kMaxNumSamples = 2000;
constexpr double kConfidence = 0.999;
// Largest ratio of scales between two views of one flight.
constexpr double kMaxScale = 3.0;
// Relief shifts a match from the plane's homography by flow * relief / height. A larger share of
// the largest shift is a mismatch along the epipolar line.
constexpr double kMaxReliefRatio = 0.3;

cv::UsacParams Sampling(double max_error_px) {
  cv::UsacParams params;
  params.confidence = kConfidence;
  params.isParallel = false;
  params.maxIterations = kMaxNumSamples;
  params.randomGeneratorState = kRandomState;
  params.threshold = max_error_px;
  return params;
}

cv::Mat Stacked(const std::vector<Eigen::Vector2d>& points) {
  cv::Mat stacked(static_cast<int>(points.size()), 2, CV_64F);
  for (int i = 0; i < stacked.rows; ++i) {
    stacked.at<double>(i, 0) = points[i].x();
    stacked.at<double>(i, 1) = points[i].y();
  }
  return stacked;
}

Eigen::Matrix3d EigenOf(const cv::Mat& matrix) {
  Eigen::Matrix3d result;
  for (int row = 0; row < 3; ++row) {
    for (int col = 0; col < 3; ++col) result(row, col) = matrix.at<double>(row, col);
  }
  return result;
}

// Neither mirrored nor shrunk to a line or a point.
bool IsBelievable(const Eigen::Matrix3d& b_from_a) {
  if (!b_from_a.allFinite() || std::abs(b_from_a(2, 2)) < 1e-9) return false;
  const double scale2 = (b_from_a / b_from_a(2, 2)).topLeftCorner<2, 2>().determinant();
  return scale2 > 1.0 / (kMaxScale * kMaxScale) && scale2 < kMaxScale * kMaxScale;
}

bool IsMarked(const cv::Mat& mask, int index) {
  return index < static_cast<int>(mask.total()) && mask.ptr<uchar>()[index] != 0;
}

}  // namespace

std::vector<int> VerifyMatches(const std::vector<Eigen::Vector2d>& points_a,
                               const std::vector<Eigen::Vector2d>& points_b,
                               double max_error_px,
                               int min_count) {
  const int count = static_cast<int>(points_a.size());
  if (count < std::max(min_count, kMinSampleSize)) return {};
  const cv::Mat a = Stacked(points_a), b = Stacked(points_b);
  cv::Mat plane_mask, epipolar_mask;
  const cv::Mat homography = cv::findHomography(a, b, plane_mask, Sampling(max_error_px));
  if (homography.empty() || cv::countNonZero(plane_mask) < min_count) return {};
  const Eigen::Matrix3d b_from_a = EigenOf(homography);
  if (!IsBelievable(b_from_a)) return {};
  double largest_flow = 0.0;
  for (int i = 0; i < count; ++i) {
    if (IsMarked(plane_mask, i)) {
      largest_flow = std::max(largest_flow, (points_a[i] - points_b[i]).norm());
    }
  }
  std::vector<int> verified, off_plane;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d on_plane = b_from_a * points_a[i].homogeneous();
    const double relief = (on_plane.hnormalized() - points_b[i]).norm();
    if (IsMarked(plane_mask, i)) {
      verified.push_back(i);
    } else if (relief < kMaxReliefRatio * largest_flow) {
      off_plane.push_back(i);
    }
  }
  // If the plane explains everything up to relief, the epipolar geometry is undetermined.
  if (off_plane.empty()) return verified;
  const cv::Mat fundamental = cv::findFundamentalMat(a, b, epipolar_mask, Sampling(max_error_px));
  for (const int i : off_plane) {
    if (!fundamental.empty() && IsMarked(epipolar_mask, i)) verified.push_back(i);
  }
  std::sort(verified.begin(), verified.end());
  return verified;
}

}  // namespace freelsd
