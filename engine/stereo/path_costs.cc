#include "engine/stereo/path_costs.h"

#include <algorithm>
#include <array>
#include <limits>

#include "engine/geometry/geometry.h"
#include "engine/stereo/lanes.h"

namespace freelsd {

namespace {

// What is asked of memory in time; a row's costs do not fit into the first cache.
constexpr int kColumnsAhead = 2;
constexpr int16_t kMaxShort = std::numeric_limits<int16_t>::max();

// Costs of one pixel along one path, after those of the pixel before.
struct PathPixel {
  alignas(sizeof(Shorts)) std::array<int16_t, PathCosts::kMaxNumDisparities + kNumLanes> costs;

  // Behind the last disparity is none to come from.
  PathPixel(int num_disparities, int16_t none) {
    std::fill(costs.begin(), costs.begin() + num_disparities, int16_t{0});
    std::fill(costs.begin() + num_disparities, costs.end(), none);
  }
};

// More than any path costs, even with p1.
int16_t None(const PathOptions& options) { return static_cast<int16_t>(kMaxShort - options.p1); }

// Cheapest way to each disparity: staying, from a neighbour, or from the cheapest of all.
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

// Costs from above of one column, and room.
int AboveStride(const MatchedColumns& columns) { return columns.num_disparities + kNumLanes; }

struct ForwardRows {
  const int16_t* column_sums;
  int16_t* block_costs;
  // Costs from above of the last row, which become sums of those from the left and from above.
  int16_t* last_from_above;
  int16_t* from_above;
  int16_t* least_from_above;
};

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
    // Before the first column stand the costs of a block that lies one to the left.
    const int16_t* last_costs = block_costs - num_disparities;
    int16_t* last_above = rows.last_from_above + x * stride;
    int16_t* from_above = rows.from_above + x * stride;
    const Shorts above_jump = p2 + rows.least_from_above[x];
    Shorts least_left = zero + kMaxShort, least_above = least_left, before_right = none;
    Shorts between, stay, after;
    Load(left.costs.data(), stay);
    Join(none, stay, between);
    for (int d = 0; d < num_disparities; d += kNumLanes) {
      Shorts cost, sum, below, beyond, way;
      __builtin_prefetch(last_above + d + kColumnsAhead * stride, 1);
      __builtin_prefetch(from_above + d + kColumnsAhead * stride, 1);
      Load(last_costs + d, cost);
      Load(entering + d, sum);
      cost += sum;
      Load(leaving + d, sum);
      cost -= sum;
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
      // One register late: the number before `straight` was still to be read.
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
  const int16_t* neighbours;
  Winner* winners;
};

// The index among lanes that hold the least sum and the number of their register.
[[gnu::always_inline]] inline int16_t IndexOf(const Shorts& is_least, const Shorts& block) {
  const Shorts lane = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
  Shorts index = is_least & (block * int16_t{kNumLanes} + lane + int16_t{1});
  const Shorts other =
      __builtin_shufflevector(index, index, 8, 9, 10, 11, 12, 13, 14, 15, 0, 1, 2, 3, 4, 5, 6, 7);
  index = index > other ? index : other;
  // 0 is no index, and must not be the least.
  const Shorts zero{};
  index = index == zero ? zero + kMaxShort : index;
  SpreadLeast(index);
  return static_cast<int16_t>(index[0] - 1);
}

[[gnu::always_inline]] inline bool IsAnySet(const Shorts& bits) {
  typedef int64_t Longs __attribute__((vector_size(32)));
  const auto longs = reinterpret_cast<Longs>(bits);
  return (longs[0] | longs[1] | longs[2] | longs[3]) != 0;
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
      const Shorts here = sum > least ? zero : block;
      least_block = here > least_block ? here : least_block;
      least = sum < least ? sum : least;
      block += one;
    }
    SpreadLeast(least_right);
    jump = least_right + p2;
    Shorts all_least = least;
    SpreadLeast(all_least);
    const int16_t index = IndexOf(all_least == least, least_block);
    Winner& winner = rows.winners[x];
    winner.index = index;
    winner.cost = all_least[0];
    winner.cost_before = sums.costs[static_cast<size_t>(std::max(index - 1, 0))];
    winner.cost_after = sums.costs[static_cast<size_t>(index + 1)];
    winner.is_unique = true;
    if (options.uniqueness_ratio_percent == 0) continue;
    // In sixteen bits, as OpenCV has it.
    const auto end_cost =
        static_cast<int16_t>(100 * winner.cost / (100 - options.uniqueness_ratio_percent) + 1);
    const Shorts end = zero + end_cost;
    Shorts near_bits = zero;
    UnsignedShorts bit = reinterpret_cast<UnsignedShorts>(one);
    for (int d = 0; d < num_disparities; d += kNumLanes) {
      Shorts sum;
      Load(sums.costs.data() + d, sum);
      near_bits |= (sum < end) & reinterpret_cast<Shorts>(bit);
      bit += bit;
    }
    Shorts neighbours;
    Load(rows.neighbours + index * kNumLanes, neighbours);
    winner.is_unique = !IsAnySet(near_bits & ~neighbours);
  }
}

}  // namespace

bool PathCosts::CanDo(const MatchedColumns& columns, const PathOptions& options) {
  const int64_t block_cost = int64_t{kMaxPixelCost} * options.block_size_px * options.block_size_px;
  const int64_t path_cost = block_cost + options.p2;
  return columns.num_disparities <= kMaxNumDisparities && 3 * path_cost <= kMaxShort &&
         path_cost + options.p2 + options.p1 <= kMaxShort;
}

PathCosts::PathCosts(const MatchedColumns& columns, const PathOptions& options)
    : columns_(columns),
      options_(options),
      block_costs_(1, (columns.count + 1) * columns.num_disparities),
      from_above_(2, columns.count * AboveStride(columns) + kNumLanes),
      least_from_above_(1, columns.count, int16_t{0}),
      neighbours_(columns.num_disparities, kNumLanes, int16_t{0}) {
  const int num_disparities = columns.num_disparities;
  std::fill_n(from_above_[0], from_above_.total(), None(options));
  for (int x = 0; x < columns.count; ++x)
    std::fill_n(FromAbove(0) + x * AboveStride(columns), num_disparities, int16_t{0});
  for (int index = 0; index < num_disparities; ++index) {
    for (int i = std::max(index - 1, 0); i <= std::min(index + 1, num_disparities - 1); ++i) {
      int16_t& bits = neighbours_(index, i % kNumLanes);
      bits = static_cast<int16_t>(bits | 1 << (i / kNumLanes));
    }
  }
}

int16_t* PathCosts::FromAbove(int row) { return from_above_[row % 2] + kNumLanes; }

void PathCosts::NextRow(const int16_t* column_sums) {
  // The block one to the left of the first: p2 makes up for what is taken off with each jump.
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
  SumBackward(columns_,
              options_,
              {block_costs_[0] + columns_.num_disparities,
               FromAbove(num_rows_ - 1),
               neighbours_[0],
               winners.data()});
}

}  // namespace freelsd
