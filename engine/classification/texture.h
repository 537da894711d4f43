// Private to classification/. How evenly bright a region is, at several scales.
#pragma once

#include <array>

#include <opencv2/core.hpp>

namespace freelsd {

// Sums over the pixels of a region within square windows, for any side at the cost of one.
class WindowSums {
 public:
  // Windows are at most max_side_px wide.
  WindowSums(const cv::Mat1f& values, const cv::Mat1b& mask, int max_side_px);

  // Mean over the part of the window about each pixel of a row that is in the region; 0 where no
  // part is. The pixel lies right of and below the middle of a window of even side.
  void MeansOfRow(int row, int side_px, float* means) const;

 private:
  int margin_px_;
  int num_cols_;
  cv::Mat1d sums_;
  cv::Mat1i counts_;
};

struct Texture {
  // Deviations of log brightness between windows of the size of leaves and tufts, and of tufts and
  // bushes; logarithms of them.
  float leaf_log_deviation = 0.0f;
  float tuft_log_deviation = 0.0f;
  // (upper + lower - 2 median) / (upper - lower) of the tails of what lies between windows of gaps
  // and of fronds: below 0 where dark gaps lie between evenly bright leaves; not moved by a few
  // sheep.
  float gap_skewness = 0.0f;
};

Texture TextureOf(const cv::Mat1f& log_grey,
                  const cv::Mat1b& mask,
                  double ground_sampling_distance_m);

}  // namespace freelsd
