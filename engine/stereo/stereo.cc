#include "engine/stereo/stereo.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "engine/check/check.h"
#include "engine/stereo/matching.h"

namespace freelsd {
namespace {

Points PointsFrom(const RectifiedPair& pair,
                  const cv::Mat1f& disparity,
                  double typical_depth,
                  const StereoOptions& options) {
  const double per_m2 = std::pow(pair.focal_px / typical_depth, 2);
  const int stride =
      std::max(1, static_cast<int>(std::round(std::sqrt(per_m2 / options.max_points_per_m2))));
  const Eigen::Matrix3d world_from_rectified = pair.world_from_left.rotation.toRotationMatrix();
  Points points;
  for (int v = 0; v < disparity.rows; v += stride) {
    for (int u = 0; u < disparity.cols; u += stride) {
      if (std::isnan(disparity(v, u))) continue;
      const double depth = pair.DepthOf(disparity(v, u));
      if (!(depth > 0.0)) continue;
      const Eigen::Vector3d ray(
          (u - pair.left_cx_px) / pair.focal_px, (v - pair.cy_px) / pair.focal_px, 1.0);
      const Eigen::Vector3d ray_in_world = world_from_rectified * ray;
      const Eigen::Vector3d point = ray_in_world * depth + pair.world_from_left.translation;
      const double depth_sd =
          depth * depth / (pair.focal_px * pair.baseline) * options.disparity_sd_px;
      points.push_back(
          {point.cast<float>(), static_cast<float>(depth_sd * std::abs(ray_in_world.z()))});
    }
  }
  return points;
}

}  // namespace

void StereoOptions::Check() const {
  const FieldCheck check("stereo");
  check.Inside("ground_sampling_distance_m", ground_sampling_distance_m, 0.01, 2.0);
  check.Require(
      min_baseline_ratio > 0.0, "min_baseline_ratio", min_baseline_ratio, "must be positive");
  check.Require(
      ideal_baseline_ratio >= min_baseline_ratio && ideal_baseline_ratio <= max_baseline_ratio,
      "ideal_baseline_ratio",
      ideal_baseline_ratio,
      "must lie between min_baseline_ratio and max_baseline_ratio");
  check.Require(
      max_baseline_ratio <= 5.0, "max_baseline_ratio", max_baseline_ratio, "must be <= 5");
  check.Require(max_axis_angle_deg > 0.0 && max_axis_angle_deg <= 90.0,
                "max_axis_angle_deg",
                max_axis_angle_deg,
                "must be in (0, 90]");
  check.Inside("num_partners", num_partners, 1, 20);
  check.Inside("num_pairs_per_place", num_pairs_per_place, 0, 20);
  check.Inside("min_needed_ratio", min_needed_ratio, 0.0, 1.0);
  check.Require(min_num_shared_landmarks >= 1,
                "min_num_shared_landmarks",
                min_num_shared_landmarks,
                "must be >= 1");
  check.Require(relief_margin_m >= 0.0, "relief_margin_m", relief_margin_m, "must be >= 0");
  check.Require(block_size_px >= 1 && block_size_px <= 21 && block_size_px % 2 == 1,
                "block_size_px",
                block_size_px,
                "must be odd, in [1, 21]");
  check.Require(p1_factor >= 1, "p1_factor", p1_factor, "must be >= 1");
  check.Require(p2_factor > p1_factor, "p2_factor", p2_factor, "must be > p1_factor");
  check.Inside("uniqueness_ratio_percent", uniqueness_ratio_percent, 0, 99);
  check.Require(speckle_size_px >= 0, "speckle_size_px", speckle_size_px, "must be >= 0");
  check.Require(max_left_right_difference_px >= 0,
                "max_left_right_difference_px",
                max_left_right_difference_px,
                "must be >= 0");
  check.Require(min_texture_grey >= 0.0, "min_texture_grey", min_texture_grey, "must be >= 0");
  check.Require(
      correlation_window_px >= 3 && correlation_window_px <= 63 && correlation_window_px % 2 == 1,
      "correlation_window_px",
      correlation_window_px,
      "must be odd, in [3, 63]");
  check.Require(min_correlation >= 0.0 && min_correlation < 1.0,
                "min_correlation",
                min_correlation,
                "must be in [0, 1)");
  check.Inside("max_num_disparities", max_num_disparities, 16, 1024);
  check.Require(
      max_points_per_m2 > 0.0, "max_points_per_m2", max_points_per_m2, "must be positive");
  check.Require(disparity_sd_px > 0.0, "disparity_sd_px", disparity_sd_px, "must be positive");
}

Points ReconstructPoints(const AdjustedBlock& block,
                         const StereoPair& pair,
                         const cv::Mat& left_image,
                         const cv::Mat& right_image,
                         const StereoOptions& options) {
  const std::optional<RectifiedPair> rectified =
      RectifyPair(block, pair, left_image, right_image, options);
  if (!rectified) return {};
  const DepthRange depths = DepthsOf(block, pair, options);
  return PointsFrom(
      *rectified, MatchRectified(*rectified, depths, options), depths.typical, options);
}

}  // namespace freelsd
