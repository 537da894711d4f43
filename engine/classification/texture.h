// Private to classification/. Evenness of a region's brightness at several scales.
#pragma once

#include <array>

#include <opencv2/core.hpp>

namespace freelsd {

// Mean log brightness over square windows of a region, at a cost that does not depend on the size
// of the window. Keeps only as many rows as the tallest window needs. Sums are exact in any order,
// because each logarithm is a multiple of 2^-23 (see log_levels.h).
class WindowSums {
 public:
  // No window may be wider than max_side_px.
  WindowSums(const cv::Mat1b& grey, const cv::Mat1b& mask, int max_side_px);

  // Writes the means of the given columns of a row to means[col]. Each mean is over the part of the
  // pixel's window that lies in the region. It is 0 if no part lies in the region. Request rows in
  // ascending order. In a window of even side, the pixel is right of the middle and below it.
  void MeansOfRow(int row, const cv::Range& cols, int side_px, float* means);

 private:
  void AddRow();
  int Place(int row) const { return row % sums_.rows; }

  cv::Mat1b grey_;
  cv::Mat1b mask_;
  int max_side_px_;
  int margin_px_;
  int num_rows_ = 0;
  // Row Place(y) holds, for each column, the sums over all rows above y and all columns to the
  // left.
  cv::Mat1d sums_;
  cv::Mat1i counts_;
};

struct Texture {
  // Logarithm of the standard deviation of a difference: mean log brightness over a small window
  // minus mean log brightness over a large window. Leaf: windows of 0.6 and 1.8 m. Tuft: 1.8 and
  // 4.2 m.
  float leaf_log_deviation = 0.0f;
  float tuft_log_deviation = 0.0f;
  // Skewness of the same difference for windows of 0.3 and 0.9 m: (upper + lower - 2 median) /
  // (upper - lower), with the 95th and 5th percentiles as upper and lower. Negative where dark gaps
  // lie between evenly bright leaves. A few sheep do not change it.
  float gap_skewness = 0.0f;
};

Texture TextureOf(const cv::Mat1b& grey, const cv::Mat1b& mask, double ground_sampling_distance_m);

}  // namespace freelsd
