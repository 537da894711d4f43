// Input: adjusted views and their images. Output: dense points in world. Paper: Sec. III-F.
#pragma once

#include <optional>
#include <vector>

#include "engine/adjustment/adjustment.h"

namespace freelsd {

struct StereoOptions {
  // --- Behaviour ---
  // Images are matched at this ground sampling distance or at full size, whichever is coarser.
  double ground_sampling_distance_m = 0.12;
  // Ideal baseline of a pair over its height, and the accepted range.
  double ideal_baseline_ratio = 0.3;
  double min_baseline_ratio = 0.08;
  double max_baseline_ratio = 0.9;
  // Largest angle between the optical axes.
  double max_axis_angle_deg = 30.0;
  // Pairs per view. Paper: one. Differs: survey photographs overlap so little that one leaves gaps.
  int num_partners = 2;
  // Least number of landmarks that the views of a pair share.
  int min_num_shared_landmarks = 8;
  // Relief above and below the sparse landmarks that the disparity range includes.
  double relief_margin_m = 15.0;
  // Semi-global matching: block, penalties (times channels * block^2), left-right check, speckles.
  int block_size_px = 7;
  int p1_factor = 8;
  int p2_factor = 32;
  int uniqueness_ratio_percent = 15;
  int speckle_size_px = 100;
  int max_left_right_difference_px = 1;
  // Least deviation of grey levels within a window: water and burnt-out ground have no texture to
  // match.
  double min_texture_grey = 1.5;
  // Least normalised cross-correlation of matched windows. At these values fewer than 0.5 % of the
  // pixels of two unrelated photographs pass, and 97 % of the true matches do.
  int correlation_window_px = 15;
  double min_correlation = 0.6;
  // Largest number of disparities searched, a multiple of 16.
  int max_num_disparities = 256;
  // Points per square metre of ground, approximately: every n-th pixel of every n-th row is kept.
  double max_points_per_m2 = 25.0;
  // Standard deviation of a disparity, for the deviation of the height.
  double disparity_sd_px = 0.35;

  void Check() const;
};

struct StereoPair {
  // Indices into AdjustedBlock::views.
  size_t left = 0;
  size_t right = 0;
  double cost = 0.0;
};

// The best partners of every connected view by baseline, epipolar and viewing cost; no pair twice.
std::vector<StereoPair> SelectPairs(const AdjustedBlock& block, const StereoOptions& options);

struct DensePoint {
  Eigen::Vector3f point_in_world = Eigen::Vector3f::Zero();
  float height_sd_m = 0.0f;
};
using Points = std::vector<DensePoint>;

// Planar rectification (Fusiello et al. 2000) and semi-global matching of one pair. Images are
// full-size, 8-bit BGR or grey; throws std::invalid_argument for others. Empty without matches
// (water, uniform ground).
Points ReconstructPoints(const AdjustedBlock& block,
                         const StereoPair& pair,
                         const cv::Mat& left_image,
                         const cv::Mat& right_image,
                         const StereoOptions& options);

}  // namespace freelsd
