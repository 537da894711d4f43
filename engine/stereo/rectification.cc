#include "engine/stereo/rectification.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>

#include <Eigen/Dense>
#include <opencv2/imgproc.hpp>

#include "engine/geometry/geometry.h"

namespace freelsd {
namespace {

// Between nodes of the remap tables, distortion is linear to a hundredth of a pixel.
constexpr int kNodeSpacingPx = 8;
// Landmarks beyond these quantiles count as outliers.
constexpr double kLowShare = 0.02;
constexpr double kHighShare = 0.98;
constexpr size_t kMinNumLandmarks = 5;
constexpr double kMinDepthRatio = 0.2;
constexpr int kMinWindowPx = 64;
constexpr int kMaxWindowPx = 6000;

// x along the baseline, z near the mean optical axis. Columns are the rectified axes in world.
std::optional<Eigen::Matrix3d> RectifiedAxes(const AdjustedView& left, const AdjustedView& right) {
  const Eigen::Vector3d baseline =
      right.world_from_camera.translation - left.world_from_camera.translation;
  const Eigen::Vector3d axis = left.world_from_camera.rotation * Eigen::Vector3d::UnitZ() +
                               right.world_from_camera.rotation * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d y = axis.cross(baseline);
  if (y.norm() < 1e-6 * axis.norm() || baseline.norm() < 1e-6) return std::nullopt;
  Eigen::Matrix3d axes;
  axes.col(0) = baseline.normalized();
  axes.col(1) = y.normalized();
  axes.col(2) = axes.col(0).cross(axes.col(1));
  return axes;
}

struct Window {
  double min_x = std::numeric_limits<double>::infinity();
  double max_x = -std::numeric_limits<double>::infinity();
  double min_y = std::numeric_limits<double>::infinity();
  double max_y = -std::numeric_limits<double>::infinity();
};

// Bounds of an image in normalised rectified coordinates, from points along its border.
Window WindowOf(const Camera& camera, const Eigen::Matrix3d& rectified_from_camera) {
  constexpr int kNumSteps = 8;
  Window window;
  const auto add = [&](double u, double v) {
    const Eigen::Vector3d ray = rectified_from_camera * camera.RayFromImage({u, v});
    if (ray.z() <= kMinDepthRatio * ray.norm()) return;
    window.min_x = std::min(window.min_x, ray.x() / ray.z());
    window.max_x = std::max(window.max_x, ray.x() / ray.z());
    window.min_y = std::min(window.min_y, ray.y() / ray.z());
    window.max_y = std::max(window.max_y, ray.y() / ray.z());
  };
  for (int i = 0; i <= kNumSteps; ++i) {
    const double u = (camera.width_px - 1.0) * i / kNumSteps;
    const double v = (camera.height_px - 1.0) * i / kNumSteps;
    add(u, 0.0);
    add(u, camera.height_px - 1.0);
    add(0.0, v);
    add(camera.width_px - 1.0, v);
  }
  return window;
}

// Where a rectified view samples an image.
struct Sampling {
  Camera camera;
  Eigen::Matrix3d camera_from_rectified;
  double focal_px = 0.0;
  double cx_px = 0.0;
  double cy_px = 0.0;
  cv::Size size{};
};

cv::Mat2f SamplingTable(const Sampling& sampling) {
  return RemapTable(sampling.size, kNodeSpacingPx, [&](double u, double v) {
    const Eigen::Vector3d ray(
        (u - sampling.cx_px) / sampling.focal_px, (v - sampling.cy_px) / sampling.focal_px, 1.0);
    return sampling.camera.ImageFromCamera(sampling.camera_from_rectified * ray);
  });
}

// 8-bit grey at the size used for matching.
cv::Mat1b GreyAtScale(const cv::Mat& image, const cv::Size& size) {
  cv::Mat grey;
  if (image.channels() == 3) {
    cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  } else {
    grey = image;
  }
  if (grey.size() == size) return grey;
  cv::Mat resized;
  cv::resize(grey, resized, size, 0, 0, cv::INTER_AREA);
  return resized;
}

cv::Mat1b InsideMask(const cv::Mat2f& table, const Camera& camera) {
  cv::Mat1b mask(table.size());
  for (int v = 0; v < table.rows; ++v) {
    for (int u = 0; u < table.cols; ++u) {
      const cv::Vec2f& at = table(v, u);
      mask(v, u) = camera.IsInside({at[0], at[1]}, 1.0) ? 255 : 0;
    }
  }
  return mask;
}

// The rectified image, and the mask of its valid pixels.
std::pair<cv::Mat1b, cv::Mat1b> Sample(const Sampling& sampling, const cv::Mat& image) {
  const cv::Mat2f table = SamplingTable(sampling);
  const cv::Size scaled(sampling.camera.width_px, sampling.camera.height_px);
  cv::Mat1b rectified;
  cv::remap(GreyAtScale(image, scaled), rectified, table, {}, cv::INTER_LINEAR);
  return {rectified, InsideMask(table, sampling.camera)};
}

// The area that both see, in the left view's coordinates.
Window Intersection(const Window& left, const Window& right, double shift) {
  return {std::max(left.min_x, right.min_x + shift),
          std::min(left.max_x, right.max_x + shift),
          std::max(left.min_y, right.min_y),
          std::min(left.max_y, right.max_y)};
}

void CheckImage(const Camera& camera, const AdjustedView& view, const cv::Mat& image) {
  const bool is_expected = image.cols == camera.width_px && image.rows == camera.height_px &&
                           (image.type() == CV_8UC1 || image.type() == CV_8UC3);
  if (is_expected) return;
  throw std::invalid_argument("stereo: frame " + view.frame_id + ": image is " +
                              std::to_string(image.cols) + "x" + std::to_string(image.rows) +
                              " of type " + std::to_string(image.type()) + ", camera says " +
                              std::to_string(camera.width_px) + "x" +
                              std::to_string(camera.height_px) + ", 8-bit grey or BGR");
}

}  // namespace

double RectifiedPair::DisparityOf(double depth) const {
  return focal_px * baseline / depth + left_cx_px - right_cx_px;
}

double RectifiedPair::DepthOf(double disparity_px) const {
  return focal_px * baseline / (disparity_px - left_cx_px + right_cx_px);
}

DepthRange DepthsOf(const AdjustedBlock& block,
                    const StereoPair& pair,
                    const StereoOptions& options) {
  const AdjustedView& left = block.views[pair.left];
  const AdjustedView& right = block.views[pair.right];
  const std::optional<Eigen::Matrix3d> axes = RectifiedAxes(left, right);
  const Eigen::Vector3d axis =
      axes ? Eigen::Vector3d(axes->col(2))
           : Eigen::Vector3d(left.world_from_camera.rotation * Eigen::Vector3d::UnitZ());
  std::vector<double> depths;
  for (const size_t landmark : left.landmarks) {
    if (!std::binary_search(right.landmarks.begin(), right.landmarks.end(), landmark)) continue;
    depths.push_back(
        axis.dot(block.landmarks[landmark].point_in_world - left.world_from_camera.translation));
  }
  DepthRange range;
  if (depths.size() >= kMinNumLandmarks) {
    std::sort(depths.begin(), depths.end());
    const auto at = [&](double share) {
      return depths[static_cast<size_t>(share * static_cast<double>(depths.size() - 1))];
    };
    range = {at(kLowShare), at(0.5), at(kHighShare)};
  } else {
    const double height = 0.5 * (left.height_above_ground + right.height_above_ground);
    range = {height, height, height};
  }
  range.nearest = std::max(range.nearest - options.relief_margin_m, kMinDepthRatio * range.typical);
  range.farthest += options.relief_margin_m;
  return range;
}

std::optional<RectifiedPair> RectifyPair(const AdjustedBlock& block,
                                         const StereoPair& pair,
                                         const cv::Mat& left_image,
                                         const cv::Mat& right_image,
                                         const StereoOptions& options) {
  CheckImage(block.camera, block.views[pair.left], left_image);
  CheckImage(block.camera, block.views[pair.right], right_image);
  const Rigid3d& world_from_left = block.views[pair.left].world_from_camera;
  const Rigid3d& world_from_right = block.views[pair.right].world_from_camera;
  const std::optional<Eigen::Matrix3d> axes =
      RectifiedAxes(block.views[pair.left], block.views[pair.right]);
  if (!axes) return std::nullopt;
  const DepthRange depths = DepthsOf(block, pair, options);
  if (depths.typical <= 0.0) return std::nullopt;
  const double native_gsd = depths.typical / block.camera.MeanFocalPx();
  const double scale = std::min(1.0, native_gsd / options.ground_sampling_distance_m);

  RectifiedPair rectified;
  rectified.world_from_left = {Eigen::Quaterniond(*axes), world_from_left.translation};
  rectified.baseline = (world_from_right.translation - world_from_left.translation).norm();
  rectified.focal_px = block.camera.Scaled(scale).MeanFocalPx();
  Sampling left{block.CameraOf(pair.left).Scaled(scale),
                world_from_left.rotation.conjugate() * *axes,
                rectified.focal_px};
  Sampling right{block.CameraOf(pair.right).Scaled(scale),
                 world_from_right.rotation.conjugate() * *axes,
                 rectified.focal_px};
  // The right image shows a point at typical depth further left by this shift.
  const double shift = rectified.baseline / depths.typical;
  const Window window =
      Intersection(WindowOf(left.camera, left.camera_from_rectified.transpose()),
                   WindowOf(right.camera, right.camera_from_rectified.transpose()),
                   shift);
  // Padding for the disparities on both sides, so that the matcher's margin costs no ground.
  const double pad = rectified.baseline * std::max(1.0 / depths.nearest - 1.0 / depths.typical,
                                                   1.0 / depths.typical - 1.0 / depths.farthest);
  const int width =
      static_cast<int>((window.max_x - window.min_x + 2.0 * pad) * rectified.focal_px);
  const int height = static_cast<int>((window.max_y - window.min_y) * rectified.focal_px);
  if (!(window.max_x > window.min_x) || std::min(width, height) < kMinWindowPx ||
      std::max(width, height) > kMaxWindowPx) {
    return std::nullopt;
  }
  left.size = right.size = cv::Size(width, height);
  left.cx_px = rectified.left_cx_px = -(window.min_x - pad) * rectified.focal_px;
  right.cx_px = rectified.right_cx_px = rectified.left_cx_px + shift * rectified.focal_px;
  left.cy_px = right.cy_px = rectified.cy_px = -window.min_y * rectified.focal_px;
  std::tie(rectified.left, rectified.is_left_inside) = Sample(left, left_image);
  std::tie(rectified.right, rectified.is_right_inside) = Sample(right, right_image);
  return rectified;
}

}  // namespace freelsd
