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
  // Ratio of a pair's baseline to its height above ground: the ideal value and the accepted range.
  double ideal_baseline_ratio = 0.3;
  double min_baseline_ratio = 0.08;
  double max_baseline_ratio = 0.9;
  // Largest angle between the optical axes.
  double max_axis_angle_deg = 30.0;
  // Each view is in its best num_partners pairs. Paper: one.
  int num_partners = 1;
  // Further pairs are taken, the best first, where fewer than this number of pairs show the ground,
  // if that is so on at least min_needed_ratio of what a pair shows. Differs: the paper has one
  // pair per view, whose heights nothing checks. 0: no further pairs.
  int num_pairs_per_place = 4;
  double min_needed_ratio = 0.05;
  // Least number of landmarks that the views of a pair share.
  int min_num_shared_landmarks = 8;
  // The range of disparities includes relief of this height above and below the sparse landmarks.
  double relief_margin_m = 15.0;
  // Parameters of semi-global matching. The penalties p1_factor and p2_factor are in units of
  // block_size_px^2.
  int block_size_px = 7;
  int p1_factor = 8;
  int p2_factor = 32;
  int uniqueness_ratio_percent = 15;
  int speckle_size_px = 100;
  int max_left_right_difference_px = 1;
  // Least standard deviation of grey levels within a window. Water and burnt-out ground have no
  // texture to match.
  double min_texture_grey = 1.5;
  // Least normalised cross-correlation of matched windows. With these values, 97 % of the true
  // matches pass, but less than 0.5 % of the pixels of two unrelated photographs.
  int correlation_window_px = 15;
  double min_correlation = 0.6;
  // Largest number of disparities searched; rounded down to a multiple of 16.
  int max_num_disparities = 256;
  // Approximate number of points per square metre of ground: every n-th pixel of every n-th row is
  // kept.
  double max_points_per_m2 = 25.0;
  // Standard deviation of a disparity. The deviation of the height is derived from it.
  double disparity_sd_px = 0.35;

  void Check() const;
};

struct StereoPair {
  // Indices into AdjustedBlock::views.
  size_t left = 0;
  size_t right = 0;
  double cost = 0.0;
};

// For each connected view, selects the num_partners pairs with the least cost, and further ones
// until num_pairs_per_place pairs show each place. No pair is returned twice. The cost combines the
// baseline ratio, the baseline's component along the optical axes, the angle between these axes,
// and missing overlap.
std::vector<StereoPair> SelectPairs(const AdjustedBlock& block, const StereoOptions& options);

struct DensePoint {
  Eigen::Vector3f point_in_world = Eigen::Vector3f::Zero();
  float height_sd_m = 0.0f;
};
using Points = std::vector<DensePoint>;

// Planar rectification (Fusiello et al. 2000) and semi-global matching of one pair. Images are
// full-size, 8-bit BGR or grey; throws std::invalid_argument for others. Empty if nothing matches
// (water, uniform ground).
Points ReconstructPoints(const AdjustedBlock& block,
                         const StereoPair& pair,
                         const cv::Mat& left_image,
                         const cv::Mat& right_image,
                         const StereoOptions& options);

}  // namespace freelsd
