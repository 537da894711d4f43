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
  // Baseline over height that a pair should have, and the range outside which it is no pair.
  double ideal_baseline_ratio = 0.3;
  double min_baseline_ratio = 0.08;
  double max_baseline_ratio = 0.9;
  // Optical axes may differ by this much.
  double max_axis_angle_deg = 30.0;
  // Pairs per view. Paper: one. Differs: survey photographs overlap so little that one leaves gaps.
  int num_partners = 2;
  // Landmarks that two views must share to be a pair.
  int min_num_shared_landmarks = 8;
  // Relief allowed above and below the sparse landmarks when bounding the disparities.
  double relief_margin_m = 15.0;
  // Semi-global matching: block, penalties (times channels * block^2), left-right check, speckles.
  int block_size_px = 7;
  int p1_factor = 8;
  int p2_factor = 32;
  int uniqueness_ratio_percent = 15;
  int speckle_size_px = 100;
  int max_left_right_difference_px = 1;
  // Windows whose grey levels deviate less than this have nothing to match: water, burnt-out
  // ground.
  double min_texture_grey = 1.5;
  // Matched windows must look alike: normalised cross-correlation. At these values less
  // than 0.5 % of the pixels of two unrelated photographs do, and 3 % of the true matches do not.
  int correlation_window_px = 15;
  double min_correlation = 0.6;
  // Disparities searched at most, a multiple of 16.
  int max_num_disparities = 256;
  // Points kept per square metre of ground, about: every n-th pixel of every n-th row is.
  double max_points_per_m2 = 25.0;
  // Standard deviation of a disparity, for the height's.
  double disparity_sd_px = 0.35;

  void Check() const;
};

struct StereoPair {
  // Indices into AdjustedBlock::views.
  size_t left = 0;
  size_t right = 0;
  double cost = 0.0;
};

// For every connected view its best partners by baseline, epipolar and viewing cost; no pair twice.
std::vector<StereoPair> SelectPairs(const AdjustedBlock& block, const StereoOptions& options);

struct DensePoint {
  Eigen::Vector3f point_in_world = Eigen::Vector3f::Zero();
  float height_sd_m = 0.0f;
};
using Points = std::vector<DensePoint>;

// Planar rectification (Fusiello et al. 2000) and semi-global matching of one pair. Images are
// full-size, 8-bit BGR or grey; std::invalid_argument for others. Empty where nothing matches
// (water, uniform ground).
Points ReconstructPoints(const AdjustedBlock& block,
                         const StereoPair& pair,
                         const cv::Mat& left_image,
                         const cv::Mat& right_image,
                         const StereoOptions& options);

}  // namespace freelsd
