#include "engine/classification/texture.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

// Sides of the averaging windows, metres on the ground.
enum Window { kGap, kFrond, kLeaf, kTuft, kBush, kNumWindows };
constexpr std::array<double, kNumWindows> kWindowsM{0.3, 0.9, 0.6, 1.8, 4.2};
// Share of the pixels at either end of a distribution that its skewness leaves out.
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

// Deviations as small as the rounding of grey levels have none.
float TailSkewness(std::vector<float> values) {
  if (values.empty()) return 0.0f;
  auto first = values.begin();
  // Ascending shares: what was put to the left stays there.
  const auto quantile = [&](double share) {
    const auto at = values.begin() +
                    static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
    std::nth_element(first, at, values.end());
    first = at;
    return *at;
  };
  const float lower = quantile(kTailRatio), median = quantile(0.5);
  const float upper = quantile(1.0 - kTailRatio);
  return (upper + lower - 2.0f * median) /
         (upper - lower + 2.0f * static_cast<float>(kTinyDeviation));
}

}  // namespace

WindowSums::WindowSums(const cv::Mat1f& values, const cv::Mat1b& mask, int max_side_px)
    : margin_px_(max_side_px / 2 + 1), num_cols_(values.cols) {
  const cv::Size size(values.cols + 2 * margin_px_, values.rows + 2 * margin_px_);
  const cv::Rect inner({margin_px_, margin_px_}, values.size());
  cv::Mat1f in_region(size, 0.0f);
  cv::Mat1b is_in_region(size, uint8_t{0});
  values.copyTo(in_region(inner), mask);
  is_in_region(inner).setTo(1, mask);
  cv::integral(in_region, sums_, CV_64F);
  cv::integral(is_in_region, counts_, CV_32S);
}

void WindowSums::MeansOfRow(int row, int side_px, float* means) const {
  const int top = row + margin_px_ - side_px / 2, left = margin_px_ - side_px / 2;
  const double *above = sums_[top] + left, *below = sums_[top + side_px] + left;
  const int *count_above = counts_[top] + left, *count_below = counts_[top + side_px] + left;
  for (int col = 0; col < num_cols_; ++col) {
    const double sum = below[col + side_px] - below[col] - above[col + side_px] + above[col];
    const int count = count_below[col + side_px] - count_below[col] - count_above[col + side_px] +
                      count_above[col];
    means[col] = static_cast<float>(sum) / static_cast<float>(std::max(count, 1));
  }
}

Texture TextureOf(const cv::Mat1f& log_grey,
                  const cv::Mat1b& mask,
                  double ground_sampling_distance_m) {
  std::array<int, kNumWindows> sides{};
  std::transform(kWindowsM.begin(), kWindowsM.end(), sides.begin(), [&](double side_m) {
    return std::max(1, cvRound(side_m / ground_sampling_distance_m));
  });
  const WindowSums sums(log_grey, mask, *std::max_element(sides.begin(), sides.end()));
  std::array<std::vector<float>, kNumWindows> means;
  for (std::vector<float>& row : means) row.resize(static_cast<size_t>(log_grey.cols));
  Spread leaf_spread, tuft_spread;
  std::vector<float> gaps;
  for (int y = 0; y < mask.rows; ++y) {
    const uint8_t* inside = mask[y];
    if (std::all_of(inside, inside + mask.cols, [](uint8_t value) { return value == 0; })) continue;
    for (size_t i = 0; i < kNumWindows; ++i) sums.MeansOfRow(y, sides[i], means[i].data());
    for (size_t x = 0; x < static_cast<size_t>(mask.cols); ++x) {
      if (inside[x] == 0) continue;
      leaf_spread.Add(means[kLeaf][x] - means[kTuft][x]);
      tuft_spread.Add(means[kTuft][x] - means[kBush][x]);
      gaps.push_back(means[kGap][x] - means[kFrond][x]);
    }
  }
  return {leaf_spread.LogDeviation(), tuft_spread.LogDeviation(), TailSkewness(std::move(gaps))};
}

}  // namespace freelsd
