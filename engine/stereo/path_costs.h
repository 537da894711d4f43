// Private to stereo/. Sums of block costs along three paths: from the left, from the right and from
// above (Hirschmueller 2008, Eq. 13), and the disparity of the least sum.
#pragma once

#include <cstdint>
#include <vector>

#include <opencv2/core.hpp>

#include "engine/stereo/block_costs.h"

namespace freelsd {

struct PathOptions {
  int block_size_px = 7;
  // For a disparity that differs by one from that of the pixel before, and by more.
  int p1 = 1;
  int p2 = 2;
  // Below 100.
  int uniqueness_ratio_percent = 0;
};

// The disparity of the least sum, counted from the least disparity, and the sums around it. Of
// equal sums OpenCV takes of each remainder by 8 the last, and of these the first.
struct Winner {
  int16_t index = 0;
  int16_t cost = 0;
  int16_t cost_before = 0;
  int16_t cost_after = 0;
  // No other but its neighbours comes near.
  bool is_unique = false;
};

class PathCosts {
 public:
  static constexpr int kMaxNumDisparities = 256;

  // Whether all sums fit into 16 bits; to others this must not be put.
  static bool CanDo(const MatchedColumns& columns, const PathOptions& options);

  PathCosts(const MatchedColumns& columns, const PathOptions& options);

  // Goes one row further, with its sums over the block's height.
  void NextRow(const int16_t* column_sums);

  // Of that row, once; one winner for each column.
  void FindWinners(std::vector<Winner>& winners);

 private:
  int16_t* FromAbove(int row);

  MatchedColumns columns_;
  PathOptions options_;
  int num_rows_ = 0;
  // One row of block costs, and two rows of costs from above with room on both sides of each
  // column's.
  cv::Mat1s block_costs_, from_above_, least_from_above_;
  // For each disparity the bits of itself and its neighbours: one for each register, in its lane.
  cv::Mat1s neighbours_;
};

}  // namespace freelsd
