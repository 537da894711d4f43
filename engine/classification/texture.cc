#include "engine/classification/texture.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "engine/classification/log_levels.h"
#include "engine/classification/order_statistics.h"
#include "engine/geometry/geometry.h"

namespace freelsd {
namespace {

// Sides of the averaging windows, metres on the ground.
enum Window { kGap, kFrond, kLeaf, kTuft, kBush, kNumWindows };
constexpr std::array<double, kNumWindows> kWindowsM{0.3, 0.9, 0.6, 1.8, 4.2};
// Share of the pixels at either end of a distribution that skewness ignores.
constexpr double kTailRatio = 0.05;
// Least deviation of log brightness: half a grey level in a hundred.
constexpr double kTinyDeviation = 0.005;

class Spread {
 public:
  void Add(double value) {
    sum_ += value;
    sum_of_squares_ += value * value;
    ++count_;
  }
  float LogDeviation() const {
    const double mean = count_ > 0 ? sum_ / count_ : 0.0;
    const double variance = count_ > 0 ? sum_of_squares_ / count_ - mean * mean : 0.0;
    return static_cast<float>(std::log(std::sqrt(std::max(variance, 0.0)) + kTinyDeviation));
  }

 private:
  double sum_ = 0.0;
  double sum_of_squares_ = 0.0;
  int count_ = 0;
};

// 0 if the deviation is as small as the rounding of grey levels.
float TailSkewness(std::vector<float> values) {
  if (values.empty()) return 0.0f;
  const auto last = static_cast<double>(values.size() - 1);
  const auto [lower, median, upper] = OfRanks(std::move(values),
                                              {static_cast<size_t>(kTailRatio * last),
                                               static_cast<size_t>(0.5 * last),
                                               static_cast<size_t>((1.0 - kTailRatio) * last)});
  return (upper + lower - 2.0f * median) /
         (upper - lower + 2.0f * static_cast<float>(kTinyDeviation));
}

// From the first to the last pixel of a row inside the region.
cv::Range ColsOf(const uint8_t* mask, int num_cols) {
  int start = 0, end = num_cols;
  while (start < end && mask[start] == 0) ++start;
  while (start < end && mask[end - 1] == 0) --end;
  return {start, end};
}

// Four corners of a window: from the row above it, and from its last row.
template <typename Number>
struct Corners {
  const Number *above, *below;
};

FREELSD_SEVERAL_TARGETS void Means(const Corners<double>& sums,
                                   const Corners<int>& counts,
                                   int side_px,
                                   int num_cols,
                                   float* __restrict__ means) {
  const double *above = sums.above, *below = sums.below;
  const int *count_above = counts.above, *count_below = counts.below;
  for (int col = 0; col < num_cols; ++col) {
    const double sum = below[col + side_px] - below[col] - above[col + side_px] + above[col];
    const int count = count_below[col + side_px] - count_below[col] - count_above[col + side_px] +
                      count_above[col];
    means[col] = static_cast<float>(sum) / static_cast<float>(std::max(count, 1));
  }
}

}  // namespace

WindowSums::WindowSums(const cv::Mat1b& grey, const cv::Mat1b& mask, int max_side_px)
    : grey_(grey),
      mask_(mask),
      max_side_px_(max_side_px),
      margin_px_(max_side_px / 2 + 1),
      sums_(max_side_px + 1, grey.cols + 2 * margin_px_, 0.0),
      counts_(sums_.size(), 0) {}

void WindowSums::AddRow() {
  const LogLevels& logs = LogOfLevel();
  const uint8_t *levels = grey_[num_rows_], *inside = mask_[num_rows_];
  const int num_cols = grey_.cols;
  const double* sums_above = sums_[Place(num_rows_)] + margin_px_;
  const int* counts_above = counts_[Place(num_rows_)] + margin_px_;
  ++num_rows_;
  double* sums = sums_[Place(num_rows_)] + margin_px_;
  int* counts = counts_[Place(num_rows_)] + margin_px_;
  double sum = 0.0;
  int count = 0;
  for (int col = 0; col < num_cols; ++col) {
    const bool is_inside = inside[col] != 0;
    sum += is_inside ? static_cast<double>(logs[levels[col]]) : 0.0;
    count += is_inside ? 1 : 0;
    sums[col + 1] = sums_above[col + 1] + sum;
    counts[col + 1] = counts_above[col + 1] + count;
  }
  std::fill_n(sums + num_cols + 1, margin_px_ - 1, sums[num_cols]);
  std::fill_n(counts + num_cols + 1, margin_px_ - 1, counts[num_cols]);
}

void WindowSums::MeansOfRow(int row, const cv::Range& cols, int side_px, float* means) {
  const auto within = [this](int y) { return std::clamp(y, 0, grey_.rows); };
  const int top = row - side_px / 2, left = margin_px_ + cols.start - side_px / 2;
  while (num_rows_ < within(row - max_side_px_ / 2 + max_side_px_)) AddRow();
  const int above = Place(within(top)), below = Place(within(top + side_px));
  Means({sums_[above] + left, sums_[below] + left},
        {counts_[above] + left, counts_[below] + left},
        side_px,
        cols.size(),
        means + cols.start);
}

Texture TextureOf(const cv::Mat1b& grey, const cv::Mat1b& mask, double ground_sampling_distance_m) {
  std::array<int, kNumWindows> sides{};
  std::transform(kWindowsM.begin(), kWindowsM.end(), sides.begin(), [&](double side_m) {
    return std::max(1, cvRound(side_m / ground_sampling_distance_m));
  });
  WindowSums sums(grey, mask, *std::max_element(sides.begin(), sides.end()));
  std::array<std::vector<float>, kNumWindows> means;
  for (std::vector<float>& row : means) row.resize(static_cast<size_t>(grey.cols));
  Spread leaf_spread, tuft_spread;
  std::vector<float> gaps;
  gaps.reserve(static_cast<size_t>(cv::countNonZero(mask)));
  for (int y = 0; y < mask.rows; ++y) {
    const uint8_t* inside = mask[y];
    const cv::Range cols = ColsOf(inside, mask.cols);
    for (size_t i = 0; i < kNumWindows; ++i) sums.MeansOfRow(y, cols, sides[i], means[i].data());
    for (auto x = static_cast<size_t>(cols.start); x < static_cast<size_t>(cols.end); ++x) {
      if (inside[x] == 0) continue;
      leaf_spread.Add(means[kLeaf][x] - means[kTuft][x]);
      tuft_spread.Add(means[kTuft][x] - means[kBush][x]);
      gaps.push_back(means[kGap][x] - means[kFrond][x]);
    }
  }
  return {leaf_spread.LogDeviation(), tuft_spread.LogDeviation(), TailSkewness(std::move(gaps))};
}

}  // namespace freelsd
