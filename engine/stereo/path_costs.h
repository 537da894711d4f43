// Private to stereo/. Sums of block costs along three paths: from the left, from the right and from
// above (Hirschmueller 2008, Eq. 13), and the disparity of the least sum.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include <opencv2/core.hpp>

#include "engine/stereo/block_costs.h"

namespace freelsd {

struct PathOptions {
  int block_size_px = 7;
  // Penalty if the disparity differs by one from that of the previous pixel.
  int p1 = 1;
  // Penalty if it differs by more. Larger than p1.
  int p2 = 2;
  // Below 100.
  int uniqueness_ratio_percent = 0;
};

// The disparity with the least sum (the first one if several are equal), and the sums of its
// neighbours. `index` is relative to the least disparity.
struct Winner {
  int16_t index = 0;
  int16_t cost = 0;
  int16_t cost_before = 0;
  int16_t cost_after = 0;
  // True if every other sum exceeds the least sum by more than uniqueness_ratio_percent. The sums
  // of the two neighbours are not checked.
  bool is_unique = false;
};

class PathCosts {
 public:
  static constexpr int kMaxNumDisparities = 1024;
  // Limit for the largest cost of a block plus p2, so that sums over three paths fit into 16 bits.
  static constexpr int kMaxPathCost = std::numeric_limits<int16_t>::max() / 3;

  PathCosts(const MatchedColumns& columns, const PathOptions& options);

  // Advances one row. `column_sums` is the result of BlockCosts::NextRow for it.
  void NextRow(const int16_t* column_sums);

  // Winners of the current row, one per column. Call it at most once per row.
  void FindWinners(std::vector<Winner>& winners);

 private:
  int16_t* FromAbove(int row);

  MatchedColumns columns_;
  PathOptions options_;
  int num_rows_ = 0;
  // One row of block costs, and two rows of costs from above with padding on both sides of each
  // column.
  cv::Mat1s block_costs_, from_above_, least_from_above_;
};

}  // namespace freelsd
