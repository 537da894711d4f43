#include "engine/stereo/block_costs.h"

#include <algorithm>
#include <cstring>

#include "engine/geometry/geometry.h"
#include "engine/stereo/lanes.h"

namespace freelsd {
namespace {

// Derivatives are clipped to this on both sides, and shifted by it to be positive.
constexpr int kMaxDerivative = 15;
// Padding, because a register may be loaded from the last column on.
constexpr int kRoomPx = 64;

// Value of each pixel of a row, and its range within half a pixel.
struct Signal {
  std::vector<uint8_t> values, low, high;

  explicit Signal(int num_cols)
      : values(static_cast<size_t>(num_cols + kRoomPx), 0), low(values), high(values) {}
};

FREELSD_SEVERAL_TARGETS void Differentiate(const std::array<const uint8_t*, 3>& rows,
                                           int num_cols,
                                           int sign,
                                           uint8_t* __restrict__ derivatives) {
  const auto [above, row, below] = rows;
  for (int x = 1; x < num_cols - 1; ++x) {
    const int sum =
        above[x + 1] - above[x - 1] + 2 * (row[x + 1] - row[x - 1]) + below[x + 1] - below[x - 1];
    derivatives[x] = static_cast<uint8_t>(std::clamp(sign * sum, -kMaxDerivative, kMaxDerivative) +
                                          kMaxDerivative);
  }
}

FREELSD_SEVERAL_TARGETS void BoundHalfway(const uint8_t* __restrict__ values,
                                          int num_cols,
                                          uint8_t* __restrict__ low,
                                          uint8_t* __restrict__ high) {
  for (int x = 1; x < num_cols - 1; ++x) {
    const int value = values[x];
    const int before = (value + values[x - 1]) / 2, after = (value + values[x + 1]) / 2;
    low[x] = static_cast<uint8_t>(std::min(std::min(before, after), value));
    high[x] = static_cast<uint8_t>(std::max(std::max(before, after), value));
  }
}

void Bound(int num_cols, Signal& signal) {
  const auto last = static_cast<size_t>(num_cols - 1);
  signal.values[0] = signal.values[last] = kMaxDerivative;
  BoundHalfway(signal.values.data(), num_cols, signal.low.data(), signal.high.data());
  for (const auto& [at, next] : {std::pair(size_t{0}, size_t{1}), std::pair(last, last - 1)}) {
    const int value = signal.values[at], between = (value + signal.values[next]) / 2;
    signal.low[at] = static_cast<uint8_t>(std::min(value, between));
    signal.high[at] = static_cast<uint8_t>(std::max(value, between));
  }
}

struct RowSignals {
  Signal derivative, grey;

  RowSignals(const cv::Mat1b& image, int row, int sign) : derivative(image.cols), grey(image.cols) {
    const int above = std::max(row - 1, 0), below = std::min(row + 1, image.rows - 1);
    Differentiate(
        {image[above], image[row], image[below]}, image.cols, sign, derivative.values.data());
    std::memcpy(grey.values.data(), image[row], static_cast<size_t>(image.cols));
    Bound(image.cols, derivative);
    Bound(image.cols, grey);
  }
};

// Distances between one left pixel and right pixels.
[[gnu::always_inline]] inline void Distances(
    const Signal& left, size_t left_at, const Signal& right, size_t right_at, Bytes& distances) {
  Bytes value, low, high;
  Load(right.values.data() + right_at, value);
  Load(right.low.data() + right_at, low);
  Load(right.high.data() + right_at, high);
  const Bytes zero{};
  const Bytes left_value = zero + left.values[left_at];
  const Bytes left_low = zero + left.low[left_at], left_high = zero + left.high[left_at];
  // Zero if the value lies in the interval.
  const Bytes to_right =
      (left_value > low ? left_value : low) - (left_value < high ? left_value : high);
  const Bytes to_left =
      (value > left_low ? value : left_low) - (value < left_high ? value : left_high);
  distances = to_right < to_left ? to_right : to_left;
}

FREELSD_SEVERAL_TARGETS void PixelCosts(const RowSignals& left,
                                        const RowSignals& right_mirrored,
                                        int mirror_col,
                                        const MatchedColumns& columns,
                                        uint8_t* __restrict__ costs) {
  const int num_sums = columns.NumSums();
  for (int i = 0; i < columns.count; ++i) {
    const auto left_at = static_cast<size_t>(columns.first + i);
    for (int d = 0; d < num_sums; d += static_cast<int>(sizeof(Bytes))) {
      const auto right_at = static_cast<size_t>(mirror_col - i + d);
      Bytes derivative, grey;
      Distances(left.derivative, left_at, right_mirrored.derivative, right_at, derivative);
      Distances(left.grey, left_at, right_mirrored.grey, right_at, grey);
      const auto quarter =
          reinterpret_cast<Bytes>(reinterpret_cast<UnsignedShorts>(grey) >> 2) & 0x3F;
      Store(derivative + quarter, costs + std::ptrdiff_t{i} * num_sums + d);
    }
  }
}

FREELSD_SEVERAL_TARGETS void LoseBits(int num_bits, int count, uint8_t* __restrict__ costs) {
  for (int i = 0; i < count; ++i) costs[i] = static_cast<uint8_t>(costs[i] >> num_bits);
}

FREELSD_SEVERAL_TARGETS void MoveSums(const uint8_t* __restrict__ entering,
                                      const uint8_t* __restrict__ leaving,
                                      int count,
                                      int16_t* __restrict__ sums) {
  for (int i = 0; i < count; ++i)
    sums[i] = static_cast<int16_t>(sums[i] + entering[i] - leaving[i]);
}

}  // namespace

BlockCosts::BlockCosts(const cv::Mat1b& left,
                       const cv::Mat1b& right_mirrored,
                       const MatchedColumns& columns,
                       const BlockOptions& options,
                       int first_row)
    : left_(left),
      right_mirrored_(right_mirrored),
      columns_(columns),
      options_(options),
      radius_px_(options.block_size_px / 2),
      first_row_(first_row),
      row_(first_row),
      costs_(2 * radius_px_ + 2, columns.count * columns.NumSums()),
      sums_(cv::Mat1s::zeros(1, columns.count * columns.NumSums())),
      num_rows_known_(first_row) {}

const uint8_t* BlockCosts::CostsOf(int row) {
  const int known = std::clamp(row, first_row_, left_.rows - 1);
  for (; num_rows_known_ <= known; ++num_rows_known_) {
    uint8_t* const costs = costs_[num_rows_known_ % costs_.rows];
    // Mirroring a row changes the sign of its derivative.
    PixelCosts(RowSignals(left_, num_rows_known_, 1),
               RowSignals(right_mirrored_, num_rows_known_, -1),
               left_.cols - 1 - columns_.first + columns_.min_disparity_px,
               columns_,
               costs);
    if (options_.num_lost_bits > 0) LoseBits(options_.num_lost_bits, costs_.cols, costs);
  }
  return costs_[known % costs_.rows];
}

const int16_t* BlockCosts::NextRow() {
  if (row_ == first_row_) {
    const std::vector<uint8_t> none(static_cast<size_t>(sums_.cols), 0);
    for (int row = row_ - radius_px_; row <= row_ + radius_px_; ++row)
      MoveSums(CostsOf(row), none.data(), sums_.cols, sums_[0]);
  } else {
    const uint8_t* entering = CostsOf(row_ + radius_px_);
    MoveSums(entering, CostsOf(row_ - radius_px_ - 1), sums_.cols, sums_[0]);
  }
  ++row_;
  return sums_[0];
}

}  // namespace freelsd
