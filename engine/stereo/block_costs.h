// Private to stereo/. How badly pixels of a rectified pair match, summed up over blocks.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <opencv2/core.hpp>

namespace freelsd {

// Columns of the left image for which every disparity has a column in the right one.
struct MatchedColumns {
  int first = 0;
  int count = 0;
  int min_disparity_px = 0;
  // A multiple of 16.
  int num_disparities = 0;

  // A multiple of 32: for each column there are as many sums, of which the last are not used.
  int NumSums() const { return (num_disparities + 31) / 32 * 32; }
};

// The largest cost of one pixel.
constexpr int kMaxPixelCost = 93;

// Cost of Birchfield and Tomasi (1998) on the clipped Sobel derivative along the row and, a quarter
// of it, on the grey: the lesser distance of the one pixel to what the other takes within half a
// pixel of its column.
class BlockCosts {
 public:
  // The images must outlive this. From `first_row` on, as if that row were the image's border.
  BlockCosts(const cv::Mat1b& left,
             const cv::Mat1b& right_mirrored,
             const MatchedColumns& columns,
             int block_size_px,
             int first_row);

  // Goes one row further; the first call gives the first row. For each column the sums over the
  // block's height, by disparity. Valid until the next call.
  const int16_t* NextRow();

 private:
  const uint8_t* CostsOf(int row);

  cv::Mat1b left_, right_mirrored_;
  MatchedColumns columns_;
  int radius_px_, first_row_, row_;
  // Costs of the last rows; row i lies at i modulo their number.
  cv::Mat1b costs_;
  cv::Mat1s sums_;
  int num_rows_known_;
};

}  // namespace freelsd
