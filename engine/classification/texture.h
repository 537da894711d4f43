// Private to classification/. Evenness of a region's brightness at several scales.
#pragma once

#include <array>

#include <opencv2/core.hpp>

namespace freelsd {

// Mean log brightness over square windows of a region, at a cost independent of their side. Keeps
// only the rows that a window reaches. Sums are exact in any order, because each logarithm is a
// multiple of 2^-23 (see log_levels.h).
class WindowSums {
 public:
  // Windows are at most max_side_px wide.
  WindowSums(const cv::Mat1b& grey, const cv::Mat1b& mask, int max_side_px);

  // Means for the given columns of a row, over the part of each pixel's window that is in the
  // region; 0 if no part is. Request rows in ascending order. In a window of even side the pixel
  // lies right of and below the middle.
  void MeansOfRow(int row, const cv::Range& cols, int side_px, float* means);

 private:
  void AddRow();
  int Place(int row) const { return row % sums_.rows; }

  cv::Mat1b grey_;
  cv::Mat1b mask_;
  int max_side_px_;
  int margin_px_;
  int num_rows_ = 0;
  // Row y, at Place(y), holds for each column the sums over all rows above and columns to the left.
  cv::Mat1d sums_;
  cv::Mat1i counts_;
};

struct Texture {
  // Log of the deviation of log brightness between windows the size of leaves and of tufts, and
  // between windows the size of tufts and of bushes.
  float leaf_log_deviation = 0.0f;
  float tuft_log_deviation = 0.0f;
  // (upper + lower - 2 median) / (upper - lower), with upper and lower tail values of the
  // difference between windows of gaps and of fronds. Negative where dark gaps lie between evenly
  // bright leaves. Robust against a few sheep.
  float gap_skewness = 0.0f;
};

Texture TextureOf(const cv::Mat1b& grey, const cv::Mat1b& mask, double ground_sampling_distance_m);

}  // namespace freelsd
