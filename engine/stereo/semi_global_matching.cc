#include "engine/stereo/semi_global_matching.h"

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <vector>

#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "engine/stereo/path_costs.h"

namespace freelsd {
namespace {

// The image is matched in this many stripes. Each begins with rows of the stripe above.
constexpr int kNumStripes = 4;

struct Stripes {
  int num_rows;
  int num_overlapping_rows;

  Stripes(int height_px, int block_size_px)
      : num_rows((height_px + kNumStripes - 1) / kNumStripes),
        num_overlapping_rows(block_size_px / 2 + 1 + (num_rows + 9) / 10) {}
};

MatchedColumns ColumnsOf(const cv::Mat1b& left, const SemiGlobalOptions& options) {
  const int first = std::max(options.min_disparity_px + options.num_disparities, 0);
  const int end = left.cols + std::min(options.min_disparity_px, 0);
  return {first, end - first, options.min_disparity_px, options.num_disparities};
}

// Low bits to drop from all costs, so that sums fit into 16 bits.
int NumLostBits(const SemiGlobalOptions& options) {
  const int area = options.block_size_px * options.block_size_px;
  const int p2 = std::min(options.p2, kMaxPixelCost * area);
  int num_bits = 0;
  while (area * (kMaxPixelCost >> num_bits) + (p2 >> num_bits) > PathCosts::kMaxPathCost)
    ++num_bits;
  return num_bits;
}

// Limits both penalties to the largest block cost.
PathOptions PathOptionsOf(const SemiGlobalOptions& options) {
  const int num_lost_bits = NumLostBits(options);
  const int max_cost = kMaxPixelCost * options.block_size_px * options.block_size_px;
  const int p2 = std::max(std::min(options.p2, max_cost) >> num_lost_bits, 2);
  const int p1 = std::clamp(options.p1 >> num_lost_bits, 1, p2 - 1);
  return {options.block_size_px, p1, p2, options.uniqueness_ratio_percent};
}

int16_t Unmatched(const SemiGlobalOptions& options) {
  return static_cast<int16_t>((options.min_disparity_px - 1) * kDisparityUnit);
}

// Minimum of the parabola through three sums, in sixteenths of a pixel.
int Refined(const Winner& winner, int num_disparities) {
  const int index = winner.index;
  if (index == 0 || index == num_disparities - 1) return index * kDisparityUnit;
  const int curvature = std::max(winner.cost_before + winner.cost_after - 2 * winner.cost, 1);
  const int slope = winner.cost_before - winner.cost_after;
  return index * kDisparityUnit + (slope * kDisparityUnit + curvature) / (curvature * 2);
}

// One row of the right image: the cheapest match of each column.
class RightRow {
 public:
  RightRow(int num_cols, const SemiGlobalOptions& options)
      : min_disparity_px_(options.min_disparity_px),
        max_difference_px_(std::max(options.max_left_right_difference_px, 1)),
        none_(Unmatched(options)),
        disparity_px_(static_cast<size_t>(num_cols)),
        cost_(static_cast<size_t>(num_cols)) {}

  void Clear() {
    std::fill(disparity_px_.begin(), disparity_px_.end(), none_);
    std::fill(cost_.begin(), cost_.end(), std::numeric_limits<int16_t>::max());
  }

  void Offer(int left_col, int disparity_px, int16_t cost) {
    const auto at = static_cast<size_t>(left_col - disparity_px);
    if (cost_[at] <= cost) return;
    cost_[at] = cost;
    disparity_px_[at] = static_cast<int16_t>(disparity_px);
  }

  // Neither of the two nearest integer disparities matches that of the right image.
  bool Contradicts(int left_col, int sixteenths) const {
    const int below = sixteenths >> 4, above = (sixteenths + kDisparityUnit - 1) >> 4;
    return Differs(left_col, below) && Differs(left_col, above);
  }

 private:
  bool Differs(int left_col, int disparity_px) const {
    const int col = left_col - disparity_px;
    if (col < 0 || col >= static_cast<int>(cost_.size())) return false;
    const int other_px = disparity_px_[static_cast<size_t>(col)];
    return other_px >= min_disparity_px_ && std::abs(other_px - disparity_px) > max_difference_px_;
  }

  int min_disparity_px_, max_difference_px_;
  int16_t none_;
  std::vector<int16_t> disparity_px_, cost_;
};

void PutRow(const std::vector<Winner>& winners,
            const MatchedColumns& columns,
            RightRow& right,
            int16_t* sixteenths) {
  right.Clear();
  for (int i = columns.count - 1; i >= 0; --i) {
    const Winner& winner = winners[static_cast<size_t>(i)];
    if (!winner.is_unique) continue;
    const int left_col = columns.first + i;
    right.Offer(left_col, columns.min_disparity_px + winner.index, winner.cost);
    sixteenths[left_col] = static_cast<int16_t>(columns.min_disparity_px * kDisparityUnit +
                                                Refined(winner, columns.num_disparities));
  }
}

void MatchStripe(const cv::Mat1b& left,
                 const cv::Mat1b& right_mirrored,
                 const SemiGlobalOptions& options,
                 int stripe,
                 cv::Mat1s& disparity) {
  const Stripes stripes(left.rows, options.block_size_px);
  const MatchedColumns columns = ColumnsOf(left, options);
  const int start = stripe * stripes.num_rows, end = std::min(start + stripes.num_rows, left.rows);
  const int first_row = std::max(start - stripes.num_overlapping_rows, 0);
  BlockCosts block_costs(
      left, right_mirrored, columns, {options.block_size_px, NumLostBits(options)}, first_row);
  PathCosts path_costs(columns, PathOptionsOf(options));
  RightRow right_row(left.cols, options);
  std::vector<Winner> winners;
  for (int row = first_row; row < end; ++row) {
    path_costs.NextRow(block_costs.NextRow());
    if (row < start) continue;
    path_costs.FindWinners(winners);
    int16_t* const sixteenths = disparity[row];
    PutRow(winners, columns, right_row, sixteenths);
    const int16_t unmatched = Unmatched(options);
    for (int x = columns.first; x < columns.first + columns.count; ++x) {
      if (sixteenths[x] != unmatched && right_row.Contradicts(x, sixteenths[x]))
        sixteenths[x] = unmatched;
    }
  }
}

}  // namespace

cv::Mat1s MatchSemiGlobally(const cv::Mat1b& left,
                            const cv::Mat1b& right,
                            const SemiGlobalOptions& options) {
  cv::Mat1s disparity(left.size(), Unmatched(options));
  if (ColumnsOf(left, options).count <= 0) return disparity;
  cv::Mat1b right_mirrored;
  cv::flip(right, right_mirrored, 1);
  cv::parallel_for_({0, kNumStripes}, [&](const cv::Range& range) {
    for (int stripe = range.start; stripe < range.end; ++stripe)
      MatchStripe(left, right_mirrored, options, stripe, disparity);
  });
  cv::medianBlur(disparity, disparity, 3);
  if (options.speckle_size_px > 0) {
    cv::filterSpeckles(disparity,
                       Unmatched(options),
                       options.speckle_size_px,
                       options.speckle_range_px * kDisparityUnit);
  }
  return disparity;
}

}  // namespace freelsd
