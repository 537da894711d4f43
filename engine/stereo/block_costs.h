// Private to stereo/. Matching costs of a rectified pair, summed over blocks.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <opencv2/core.hpp>

namespace freelsd {

// The columns of the left image whose match lies inside the right image for every disparity.
struct MatchedColumns {
  int first = 0;
  int count = 0;
  int min_disparity_px = 0;
  // A multiple of 16.
  int num_disparities = 0;

  // Number of sums per column: num_disparities, rounded up to a multiple of 32. Sums beyond
  // num_disparities are not used.
  int NumSums() const { return (num_disparities + 31) / 32 * 32; }
};

// The largest cost of one pixel.
constexpr int kMaxPixelCost = 93;

struct BlockOptions {
  int block_size_px = 7;
  // Number of low bits dropped from pixel costs, so that sums over a large block fit into 16 bits.
  int num_lost_bits = 0;
};

// Cost of Birchfield and Tomasi (1998). It is the distance between a pixel's value and the range of
// values within half a pixel in the other image. The distance is computed for the left pixel in the
// right image, and for the right pixel in the left image. The smaller one is used. It is computed
// on the clipped Sobel derivative along the row. A quarter of the same cost on grey levels is
// added.
class BlockCosts {
 public:
  // The images must outlive this object. Treats first_row as the upper border of the image.
  BlockCosts(const cv::Mat1b& left,
             const cv::Mat1b& right_mirrored,
             const MatchedColumns& columns,
             const BlockOptions& options,
             int first_row);

  // Advances one row; the first call gives first_row. Returns sums over the height of the block, in
  // order of column, then disparity. The pointer is valid until the next call.
  const int16_t* NextRow();

 private:
  const uint8_t* CostsOf(int row);

  cv::Mat1b left_, right_mirrored_;
  MatchedColumns columns_;
  BlockOptions options_;
  int radius_px_, first_row_, row_;
  // Ring buffer of the costs of the last rows: row i is stored at i modulo the number of rows.
  cv::Mat1b costs_;
  cv::Mat1s sums_;
  int num_rows_known_;
};

}  // namespace freelsd
