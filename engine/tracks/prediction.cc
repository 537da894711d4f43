#include "engine/tracks/prediction.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

// Rays less steep than this sine see ground that is too far away.
constexpr double kMinDescent = 0.05;
// Places per axis at which the overlap is computed.
constexpr int kNumSteps = 8;
// Share of the image width.
constexpr double kBeyondRatio = 0.3;
// Nearest to the edge of the warped image that a point is followed.
constexpr double kEdgePx = 5.0;

cv::Mat CvOf(const Eigen::Matrix3d& matrix) {
  cv::Mat result(3, 3, CV_64F);
  for (int row = 0; row < 3; ++row) {
    for (int col = 0; col < 3; ++col) result.at<double>(row, col) = matrix(row, col);
  }
  return result;
}

Eigen::Vector2d Mapped(const Eigen::Matrix3d& homography, const Eigen::Vector2d& point) {
  return (homography * point.homogeneous()).hnormalized();
}

// The part of `to` that may show what `from` shows, with a margin for the window of the follower.
cv::Rect SharedPart(const PosedImage& from, const PosedImage& to, const PlaneOverlap& overlap) {
  constexpr int kMarginPx = 16;
  const double width = from.image.grey.cols - 1.0, height = from.image.grey.rows - 1.0;
  Eigen::AlignedBox2d box;
  for (const Eigen::Vector2d& corner : {Eigen::Vector2d(0.0, 0.0),
                                        Eigen::Vector2d(width, 0.0),
                                        Eigen::Vector2d(0.0, height),
                                        Eigen::Vector2d(width, height)}) {
    // The homography of a tilted camera may throw a corner beyond its horizon.
    if ((overlap.to_from_from * corner.homogeneous()).z() <= 0.0) {
      return {cv::Point(), to.image.grey.size()};
    }
    box.extend(Mapped(overlap.to_from_from, corner));
  }
  constexpr double kFarPx = 1e6;
  const Eigen::Vector2d min = box.min().cwiseMax(-kFarPx), max = box.max().cwiseMin(kFarPx);
  const cv::Rect part(static_cast<int>(min.x()) - kMarginPx,
                      static_cast<int>(min.y()) - kMarginPx,
                      static_cast<int>(max.x() - min.x()) + 2 * kMarginPx,
                      static_cast<int>(max.y() - min.y()) + 2 * kMarginPx);
  return part & cv::Rect(cv::Point(), to.image.grey.size());
}

// Mean and deviation of grey values.
struct Brightness {
  double mean = 0.0;
  double sd = 1.0;
};
Brightness BrightnessOf(const cv::Mat& grey) {
  cv::Scalar mean, sd;
  cv::meanStdDev(grey, mean, sd);
  return {mean[0], std::max(sd[0], 1.0)};
}

// `from` as `to` would show it, with the brightness of `to`.
TrackingImage Warped(const PosedImage& from, const PosedImage& to, const PlaneOverlap& overlap) {
  const cv::Rect part = SharedPart(from, to, overlap);
  TrackingImage warped;
  warped.scale = to.image.scale;
  warped.grey = to.image.grey.clone();
  if (part.empty()) return WithPyramid(std::move(warped));
  Eigen::Matrix3d shift = Eigen::Matrix3d::Identity();
  shift(0, 2) = -part.x;
  shift(1, 2) = -part.y;
  cv::Mat shown = warped.grey(part);
  const Brightness there = BrightnessOf(shown);
  cv::warpPerspective(from.image.grey,
                      shown,
                      CvOf(shift * overlap.to_from_from),
                      part.size(),
                      cv::INTER_LINEAR,
                      cv::BORDER_REPLICATE);
  const Brightness here = BrightnessOf(shown);
  const double gain = there.sd / here.sd;
  shown.convertTo(shown, CV_8U, gain, there.mean - gain * here.mean);
  return WithPyramid(std::move(warped));
}

}  // namespace

std::optional<Eigen::Vector2d> TransferOverGround(const PosedImage& from,
                                                  const PosedImage& to,
                                                  const Eigen::Vector2d& point_in_from,
                                                  double ground_height) {
  const Rigid3d& world_from_from = from.world_from_camera;
  const Eigen::Vector3d ray = world_from_from.rotation * from.camera.RayFromImage(point_in_from);
  const double down = ground_height - world_from_from.translation.z();
  if (!(ray.z() < -kMinDescent) || down >= 0.0) return std::nullopt;
  const Eigen::Vector3d ground = world_from_from.translation + ray * (down / ray.z());
  return to.camera.ImageFromCamera(Inverse(to.world_from_camera) * ground);
}

std::optional<PlaneOverlap> OverlapOverGround(const PosedImage& from,
                                              const PosedImage& to,
                                              double ground_height) {
  std::vector<cv::Point2f> in_from, in_to;
  int num_shown = 0;
  for (int row = 0; row <= kNumSteps; ++row) {
    for (int col = 0; col <= kNumSteps; ++col) {
      const Eigen::Vector2d pixel(col * (to.camera.width_px - 1.0) / kNumSteps,
                                  row * (to.camera.height_px - 1.0) / kNumSteps);
      const auto there = TransferOverGround(to, from, pixel, ground_height);
      // Places somewhat beyond the edge keep the homography of a narrow overlap well determined.
      if (!there || !from.camera.IsInside(*there, -kBeyondRatio * from.camera.width_px)) continue;
      in_to.push_back(to.image.ReducedFromFull(pixel));
      in_from.push_back(from.image.ReducedFromFull(*there));
      num_shown += from.camera.IsInside(*there);
    }
  }
  if (num_shown == 0) return std::nullopt;
  const cv::Mat homography = cv::findHomography(in_from, in_to);
  if (homography.empty()) return std::nullopt;
  PlaneOverlap overlap;
  for (int row = 0; row < 3; ++row) {
    for (int col = 0; col < 3; ++col) {
      overlap.to_from_from(row, col) = homography.at<double>(row, col);
    }
  }
  overlap.ratio = static_cast<double>(num_shown) / ((kNumSteps + 1) * (kNumSteps + 1));
  return overlap;
}

std::vector<std::optional<Eigen::Vector2d>> FollowOverGround(
    const PosedImage& from,
    const PosedImage& to,
    const PlaneOverlap& overlap,
    const std::vector<Eigen::Vector2d>& points_in_from,
    const std::vector<Eigen::Vector2d>& guesses_in_to,
    const TracksOptions& options) {
  std::vector<Eigen::Vector2d> starts;
  starts.reserve(points_in_from.size());
  for (const Eigen::Vector2d& point : points_in_from) {
    const cv::Point2f reduced = from.image.ReducedFromFull(point);
    const Eigen::Vector2d start = Mapped(overlap.to_from_from, {reduced.x, reduced.y});
    starts.push_back(
        to.image.FullFromReduced({static_cast<float>(start.x()), static_cast<float>(start.y())}));
  }
  auto followed =
      FollowCorners(Warped(from, to, overlap), to.image, starts, guesses_in_to, options);
  // Half of the window would show nothing.
  for (size_t i = 0; i < followed.size(); ++i) {
    if (!from.camera.IsInside(points_in_from[i], kEdgePx / from.image.scale)) followed[i].reset();
  }
  return followed;
}

Eigen::Quaterniond TurnedToFit(const PosedImage& to,
                               const std::vector<Eigen::Vector2d>& expected,
                               const std::vector<Eigen::Vector2d>& found) {
  Eigen::Matrix3d correlation = Eigen::Matrix3d::Zero();
  for (size_t i = 0; i < found.size(); ++i) {
    correlation +=
        to.camera.RayFromImage(expected[i]) * to.camera.RayFromImage(found[i]).transpose();
  }
  // Kabsch: the rotation that turns the found rays to the expected ones.
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(correlation,
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0;
  const Eigen::Matrix3d expected_from_found =
      svd.matrixU() * Eigen::Vector3d(1.0, 1.0, sign).asDiagonal() * svd.matrixV().transpose();
  return (to.world_from_camera.rotation * Eigen::Quaterniond(expected_from_found)).normalized();
}

}  // namespace freelsd
