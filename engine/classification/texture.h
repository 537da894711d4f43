// Private to classification/. How evenly bright a region is, at several scales.
#pragma once

#include <array>

#include <opencv2/core.hpp>

namespace freelsd {

// Mean log brightness over square windows of a region, for any side at the cost of one. Goes down
// the rows and keeps those that a window reaches. Sums of logarithms are exact: each is a multiple
// of 2^-23 (see log_levels.h), so that it does not matter in which order they are added up.
class WindowSums {
 public:
  // Windows are at most max_side_px wide.
  WindowSums(const cv::Mat1b& grey, const cv::Mat1b& mask, int max_side_px);

  // Means over the part of the window about each pixel of a row that is in the region, of the given
  // columns; 0 where no part is. Rows are not asked for after later ones. The pixel lies right of
  // and below the middle of a window of even side.
  void MeansOfRow(int row, const cv::Range& cols, int side_px, float* means);

 private:
  void AddRow();
  int Place(int row) const { return row % sums_.rows; }

  cv::Mat1b grey_;
  cv::Mat1b mask_;
  int max_side_px_;
  int margin_px_;
  int num_rows_ = 0;
  // Row y, at Place(y), holds sums over the rows above y and the columns left of each.
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

Texture TextureOf(const cv::Mat1b& grey, const cv::Mat1b& mask, double ground_sampling_distance_m);

}  // namespace freelsd
