#include "engine/stereo/path_costs.h"

#include <algorithm>
#include <array>
#include <limits>

#include "engine/geometry/geometry.h"
#include "engine/stereo/lanes.h"

namespace freelsd {

namespace {

// Prefetch distance in columns: the costs of a row do not fit into the first-level cache.
constexpr int kColumnsAhead = 2;
constexpr int16_t kMaxShort = std::numeric_limits<int16_t>::max();

// Costs of one pixel along one path, computed from those of the previous pixel.
struct PathPixel {
  alignas(sizeof(Shorts)) std::array<int16_t, PathCosts::kMaxNumDisparities + kNumLanes> costs;

  // Beyond the last disparity there is no predecessor.
  PathPixel(int num_disparities, int16_t none) {
    std::fill(costs.begin(), costs.begin() + num_disparities, int16_t{0});
    std::fill(costs.begin() + num_disparities, costs.end(), none);
  }
};

// More than any path costs, even after p1 is added.
int16_t None(const PathOptions& options) { return static_cast<int16_t>(kMaxShort - options.p1); }

// Cheapest predecessor of each disparity: the same, a neighbour, or the cheapest of all.
[[gnu::always_inline]] inline void CheapestWay(const Shorts& stay,
                                               const Shorts& from_below,
                                               const Shorts& from_beyond,
                                               const Shorts& jump,
                                               const Shorts& p1,
                                               Shorts& way) {
  const Shorts near = (from_below < from_beyond ? from_below : from_beyond) + p1;
  const Shorts far = stay < jump ? stay : jump;
  way = near < far ? near : far;
}

// Stride between columns of costs from above, with padding.
int AboveStride(const MatchedColumns& columns) { return columns.num_disparities + kNumLanes; }

struct ForwardRows {
  const int16_t* column_sums;
  int16_t* block_costs;
  // Costs from above of the last row; replaced by the sums of left and above.
  int16_t* last_from_above;
  int16_t* from_above;
  int16_t* least_from_above;
};

// Costs of the block one column to the right: plus the column that enters, less the one that
// leaves.
[[gnu::always_inline]] inline void SlideBlock(const int16_t* last,
                                              const int16_t* entering,
                                              const int16_t* leaving,
                                              Shorts& cost) {
  Shorts sum;
  Load(last, cost);
  Load(entering, sum);
  cost += sum;
  Load(leaving, sum);
  cost -= sum;
}

FREELSD_SEVERAL_TARGETS void SumForward(const MatchedColumns columns,
                                        const PathOptions options,
                                        const ForwardRows rows) {
  const Shorts zero{}, p1 = zero + static_cast<int16_t>(options.p1);
  const Shorts p2 = zero + static_cast<int16_t>(options.p2), none = zero + None(options);
  PathPixel left(columns.num_disparities, None(options));
  Shorts left_jump = p2;
  const int num_disparities = columns.num_disparities, num_sums = columns.NumSums();
  const int stride = AboveStride(columns), radius_px = options.block_size_px / 2;
  for (int x = 0; x < columns.count; ++x) {
    const int16_t* entering =
        rows.column_sums + std::min(x + radius_px, columns.count - 1) * num_sums;
    const int16_t* leaving = rows.column_sums + std::max(x - radius_px - 1, 0) * num_sums;
    int16_t* block_costs = rows.block_costs + x * num_disparities;
    // Before the first column: costs of the block one column to the left.
    const int16_t* last_costs = block_costs - num_disparities;
    int16_t* last_above = rows.last_from_above + x * stride;
    int16_t* from_above = rows.from_above + x * stride;
    const Shorts above_jump = p2 + rows.least_from_above[x];
    Shorts least_left = zero + kMaxShort, least_above = least_left, before_right = none;
    Shorts between, stay, after;
    Load(left.costs.data(), stay);
    Join(none, stay, between);
    for (int d = 0; d < num_disparities; d += kNumLanes) {
      Shorts cost, below, beyond, way;
      __builtin_prefetch(last_above + d + kColumnsAhead * stride, 1);
      __builtin_prefetch(from_above + d + kColumnsAhead * stride, 1);
      SlideBlock(last_costs + d, entering + d, leaving + d, cost);
      Store(cost, block_costs + d);

      Load(left.costs.data() + d + kNumLanes, after);
      OneBefore(between, stay, below);
      Join(stay, after, between);
      OneAfter(stay, between, beyond);
      CheapestWay(stay, below, beyond, left_jump, p1, way);
      const Shorts from_left = cost + (way - left_jump);
      Store(from_left, left.costs.data() + d);
      least_left = from_left < least_left ? from_left : least_left;
      stay = after;

      Shorts straight;
      Load(last_above + d, straight);
      Load(last_above + d - 1, below);
      Load(last_above + d + 1, beyond);
      // Stored one register late, because `straight` still reads the previous number.
      Store(before_right, last_above + d - kNumLanes);
      CheapestWay(straight, below, beyond, above_jump, p1, way);
      const Shorts above = cost + (way - above_jump);
      Store(above, from_above + d);
      least_above = above < least_above ? above : least_above;
      before_right = from_left + above;
    }
    Store(before_right, last_above + num_disparities - kNumLanes);
    SpreadLeast(least_left);
    left_jump = least_left + p2;
    SpreadLeast(least_above);
    rows.least_from_above[x] = least_above[0];
  }
}

struct BackwardRows {
  const int16_t* block_costs;
  const int16_t* before_right;
  Winner* winners;
};

// First index among lanes with the least sum; `blocks` holds the register number of each lane.
[[gnu::always_inline]] inline int16_t FirstIndexOf(const Shorts& is_least, const Shorts& blocks) {
  const Shorts lane = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
  const Shorts zero{};
  Shorts index = is_least ? blocks * int16_t{kNumLanes} + lane : zero + kMaxShort;
  SpreadLeast(index);
  return index[0];
}

// Whether a sum other than that at `index` and its neighbours is below `end`.
[[gnu::always_inline]] inline bool IsAnotherBelow(const int16_t* sums,
                                                  int num_sums,
                                                  int index,
                                                  int16_t end) {
  int num_near = 0;
  for (int i = std::max(index - 1, 0); i <= std::min(index + 1, num_sums - 1); ++i)
    num_near += static_cast<int>(sums[i] < end);
  const Shorts zero{}, ends = zero + end;
  Shorts num_below = zero;
  for (int d = 0; d < num_sums; d += kNumLanes) {
    Shorts sum;
    Load(sums + d, sum);
    // A true lane is -1.
    num_below -= sum < ends;
  }
  return SumOf(num_below) > num_near;
}

FREELSD_SEVERAL_TARGETS void SumBackward(const MatchedColumns columns,
                                         const PathOptions options,
                                         const BackwardRows rows) {
  const Shorts zero{}, p1 = zero + static_cast<int16_t>(options.p1);
  const Shorts p2 = zero + static_cast<int16_t>(options.p2), none = zero + None(options);
  const Shorts one = zero + int16_t{1};
  const int num_disparities = columns.num_disparities, stride = AboveStride(columns);
  PathPixel right(num_disparities, None(options));
  PathPixel sums(num_disparities, 0);
  Shorts jump = p2;
  for (int x = columns.count - 1; x >= 0; --x) {
    const int16_t* block_costs = rows.block_costs + x * num_disparities;
    const int16_t* before_right = rows.before_right + x * stride;
    Shorts least_right = zero + kMaxShort, least = least_right;
    Shorts block = zero, least_block = zero;
    Shorts between, stay, after;
    Load(right.costs.data(), stay);
    Join(none, stay, between);
    for (int d = 0; d < num_disparities; d += kNumLanes) {
      Shorts cost, sum, below, beyond, way;
      Load(block_costs + d, cost);
      Load(right.costs.data() + d + kNumLanes, after);
      OneBefore(between, stay, below);
      Join(stay, after, between);
      OneAfter(stay, between, beyond);
      CheapestWay(stay, below, beyond, jump, p1, way);
      const Shorts from_right = cost + (way - jump);
      Store(from_right, right.costs.data() + d);
      least_right = from_right < least_right ? from_right : least_right;
      stay = after;

      Load(before_right + d, sum);
      sum += from_right;
      Store(sum, sums.costs.data() + d);
      least_block = sum < least ? block : least_block;
      least = sum < least ? sum : least;
      block += one;
    }
    SpreadLeast(least_right);
    jump = least_right + p2;
    Shorts all_least = least;
    SpreadLeast(all_least);
    const int16_t index = FirstIndexOf(all_least == least, least_block);
    Winner& winner = rows.winners[x];
    winner.index = index;
    winner.cost = all_least[0];
    winner.cost_before = sums.costs[static_cast<size_t>(std::max(index - 1, 0))];
    winner.cost_after = sums.costs[static_cast<size_t>(index + 1)];
    const int end_cost = 100 * winner.cost / (100 - options.uniqueness_ratio_percent) + 1;
    winner.is_unique = options.uniqueness_ratio_percent == 0 ||
                       !IsAnotherBelow(sums.costs.data(),
                                       num_disparities,
                                       index,
                                       static_cast<int16_t>(std::min<int>(end_cost, kMaxShort)));
  }
}

}  // namespace

PathCosts::PathCosts(const MatchedColumns& columns, const PathOptions& options)
    : columns_(columns),
      options_(options),
      block_costs_(1, (columns.count + 1) * columns.num_disparities),
      from_above_(2, columns.count * AboveStride(columns) + kNumLanes),
      least_from_above_(1, columns.count, int16_t{0}) {
  const int num_disparities = columns.num_disparities;
  std::fill_n(from_above_[0], from_above_.total(), None(options));
  for (int x = 0; x < columns.count; ++x)
    std::fill_n(FromAbove(0) + x * AboveStride(columns), num_disparities, int16_t{0});
}

int16_t* PathCosts::FromAbove(int row) { return from_above_[row % 2] + kNumLanes; }

void PathCosts::NextRow(const int16_t* column_sums) {
  // The block left of the first column: p2 offsets the amount subtracted at each jump.
  int16_t* const first_costs = block_costs_[0];
  std::fill_n(first_costs, columns_.num_disparities, static_cast<int16_t>(options_.p2));
  const int radius_px = options_.block_size_px / 2;
  for (int i = -radius_px - 1; i < radius_px; ++i) {
    const int16_t* sums = column_sums + std::clamp(i, 0, columns_.count - 1) * columns_.NumSums();
    for (int d = 0; d < columns_.num_disparities; ++d)
      first_costs[d] = static_cast<int16_t>(first_costs[d] + sums[d]);
  }
  SumForward(columns_,
             options_,
             {column_sums,
              first_costs + columns_.num_disparities,
              FromAbove(num_rows_),
              FromAbove(num_rows_ + 1),
              least_from_above_[0]});
  ++num_rows_;
}

void PathCosts::FindWinners(std::vector<Winner>& winners) {
  winners.resize(static_cast<size_t>(columns_.count));
  SumBackward(
      columns_,
      options_,
      {block_costs_[0] + columns_.num_disparities, FromAbove(num_rows_ - 1), winners.data()});
}

}  // namespace freelsd
