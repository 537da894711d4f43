// Private to stereo/. Matching costs of a rectified pair, summed over blocks.
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

  // A multiple of 32: the number of sums per column, of which the last may be unused.
  int NumSums() const { return (num_disparities + 31) / 32 * 32; }
};

// The largest cost of one pixel.
constexpr int kMaxPixelCost = 93;

struct BlockOptions {
  int block_size_px = 7;
  // Number of low bits dropped from pixel costs, so that sums over a large block fit.
  int num_lost_bits = 0;
};

// Cost of Birchfield and Tomasi (1998): distance of a pixel to the interval of the other image's
// values within half a pixel, the smaller of both directions. Taken on the clipped Sobel derivative
// along the row; a quarter of the cost on grey is added.
class BlockCosts {
 public:
  // The images must outlive this. Treats first_row as the upper border of the image.
  BlockCosts(const cv::Mat1b& left,
             const cv::Mat1b& right_mirrored,
             const MatchedColumns& columns,
             const BlockOptions& options,
             int first_row);

  // Advances one row; the first call gives the first row. Returns the sums over the block's height,
  // by column and disparity. Valid until the next call.
  const int16_t* NextRow();

 private:
  const uint8_t* CostsOf(int row);

  cv::Mat1b left_, right_mirrored_;
  MatchedColumns columns_;
  BlockOptions options_;
  int radius_px_, first_row_, row_;
  // Costs of the last rows; row i is at i modulo their number.
  cv::Mat1b costs_;
  cv::Mat1s sums_;
  int num_rows_known_;
};

}  // namespace freelsd
