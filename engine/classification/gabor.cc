#include "engine/classification/gabor.h"

#include <algorithm>
#include <cstring>
#include <functional>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "engine/geometry/geometry.h"

namespace freelsd {
namespace {

// Paper Sec. III-D: sigma, aspect ratio, phase, wavelengths (px), directions.
constexpr double kSigmaPx = 4.0;
constexpr double kAspectRatio = 0.02;
constexpr double kPhase = 0.0;
constexpr std::array<double, kNumGaborWavelengths> kWavelengthsPx{0.5, 1.0, 5.0};
constexpr int kNumDirections = 4;
constexpr int kSidePx = 2 * kGaborRadiusPx + 1;
constexpr size_t kNumOffsets = kGaborRadiusPx + 1;

// Pixels per block: two registers of eight.
constexpr int kBlockPx = 16;
constexpr int kRegisterPx = 8;
typedef float Register __attribute__((vector_size(kRegisterPx * sizeof(float))));

// The mean of the four directions is symmetric in x, y and their signs. So each pair i <= j of
// offsets has one weight, for the sum of all pixels (+-i, +-j) and (+-j, +-i).
struct Weight {
  size_t i = 0;
  size_t j = 0;
  std::array<float, kNumGaborWavelengths> of_sum{};
};

std::vector<Weight> FoldedWeights() {
  const auto kernels = MeanGaborKernels();
  std::vector<Weight> weights;
  for (size_t j = 0; j < kNumOffsets; ++j) {
    for (size_t i = 0; i <= j; ++i) {
      Weight weight{i, j, {}};
      // The sum counts pixels on an axis or a diagonal twice.
      const float times = (i == 0 ? 2.0f : 1.0f) * (j == 0 ? 2.0f : 1.0f) * (i == j ? 2.0f : 1.0f);
      for (size_t k = 0; k < kNumGaborWavelengths; ++k) {
        weight.of_sum[k] =
            kernels[k](kGaborRadiusPx + static_cast<int>(j), kGaborRadiusPx + static_cast<int>(i)) /
            times;
      }
      weights.push_back(weight);
    }
  }
  return weights;
}

// Row y + j plus row y - j, for every j.
using FoldedRows = std::array<std::vector<float>, kNumOffsets>;

void FoldRows(const cv::Mat1f& padded, int y, FoldedRows& folded) {
  for (size_t j = 0; j < kNumOffsets; ++j) {
    const float* below = padded[y + static_cast<int>(j)];
    const float* above = padded[y - static_cast<int>(j)];
    std::transform(below, below + padded.cols, above, folded[j].begin(), std::plus<>());
  }
}

using ResponseRows = std::array<float*, kNumGaborWavelengths>;

// Responses of kBlockPx pixels from x on. Folded rows hold pixel x at x + kGaborRadiusPx.
[[gnu::always_inline]] inline void FilterBlock(const FoldedRows& folded,
                                               const std::vector<Weight>& weights,
                                               int x,
                                               const ResponseRows& responses) {
  Register sums[kNumGaborWavelengths][2] = {};
  for (const Weight& weight : weights) {
    const float* row_j = folded[weight.j].data() + x + kGaborRadiusPx;
    const float* row_i = folded[weight.i].data() + x + kGaborRadiusPx;
    for (int half = 0; half < 2; ++half) {
      const int at = half * kRegisterPx;
      const auto i = static_cast<int>(weight.i), j = static_cast<int>(weight.j);
      Register below, above, right, left;
      std::memcpy(&below, row_j + at + i, sizeof(Register));
      std::memcpy(&above, row_j + at - i, sizeof(Register));
      std::memcpy(&right, row_i + at + j, sizeof(Register));
      std::memcpy(&left, row_i + at - j, sizeof(Register));
      const Register sum = (below + above) + (right + left);
      for (size_t k = 0; k < kNumGaborWavelengths; ++k) sums[k][half] += weight.of_sum[k] * sum;
    }
  }
  for (size_t k = 0; k < kNumGaborWavelengths; ++k) {
    std::memcpy(responses[k] + x, sums[k], sizeof(sums[k]));
  }
}

[[gnu::always_inline]] inline void FilterMasked(const FoldedRows& folded,
                                                const std::vector<Weight>& weights,
                                                const uint8_t* mask,
                                                int num_cols,
                                                const ResponseRows& responses) {
  for (int x = 0; x < num_cols; x += kBlockPx) {
    const uint8_t* end = mask + std::min(x + kBlockPx, num_cols);
    if (std::any_of(mask + x, end, [](uint8_t inside) { return inside != 0; })) {
      FilterBlock(folded, weights, x, responses);
    }
  }
}

using RowFilter = void (*)(
    const FoldedRows&, const std::vector<Weight>&, const uint8_t*, int, const ResponseRows&);

void FilterRow(const FoldedRows& folded,
               const std::vector<Weight>& weights,
               const uint8_t* mask,
               int num_cols,
               const ResponseRows& responses) {
  FilterMasked(folded, weights, mask, num_cols, responses);
}

#if defined(__x86_64__)
// No fused multiplications, so that every processor rounds alike.
[[gnu::target("avx2")]] void FilterRowAvx2(const FoldedRows& folded,
                                           const std::vector<Weight>& weights,
                                           const uint8_t* mask,
                                           int num_cols,
                                           const ResponseRows& responses) {
  FilterMasked(folded, weights, mask, num_cols, responses);
}

RowFilter FastestRowFilter() {
  return __builtin_cpu_supports("avx2") != 0 ? FilterRowAvx2 : FilterRow;
}
#else
RowFilter FastestRowFilter() { return FilterRow; }
#endif

}  // namespace

std::array<cv::Mat1f, kNumGaborWavelengths> MeanGaborKernels() {
  std::array<cv::Mat1f, kNumGaborWavelengths> kernels;
  for (size_t k = 0; k < kernels.size(); ++k) {
    cv::Mat1d sum(kSidePx, kSidePx, 0.0);
    for (int direction = 0; direction < kNumDirections; ++direction) {
      sum += cv::getGaborKernel({kSidePx, kSidePx},
                                kSigmaPx,
                                kPi * direction / kNumDirections,
                                kWavelengthsPx[k],
                                kAspectRatio,
                                kPhase,
                                CV_64F);
    }
    sum.convertTo(kernels[k], CV_32F, 1.0 / kNumDirections);
  }
  return kernels;
}

std::array<cv::Mat1f, kNumGaborWavelengths> GaborResponses(const cv::Mat1f& grey,
                                                           const cv::Mat1b& mask) {
  static const std::vector<Weight> kWeights = FoldedWeights();
  static const RowFilter kFilterRow = FastestRowFilter();
  // Blocks may extend beyond the last column.
  const int num_cols = (grey.cols + kBlockPx - 1) / kBlockPx * kBlockPx;
  cv::Mat1f padded;
  cv::copyMakeBorder(grey,
                     padded,
                     kGaborRadiusPx,
                     kGaborRadiusPx,
                     kGaborRadiusPx,
                     kGaborRadiusPx + num_cols - grey.cols,
                     cv::BORDER_REFLECT_101);
  std::array<cv::Mat1f, kNumGaborWavelengths> responses;
  for (cv::Mat1f& response : responses) response = cv::Mat1f(grey.rows, num_cols, 0.0f);
  FoldedRows folded;
  for (std::vector<float>& row : folded) row.resize(static_cast<size_t>(padded.cols));
  for (int y = 0; y < grey.rows; ++y) {
    const uint8_t* inside = mask[y];
    if (std::none_of(inside, inside + mask.cols, [](uint8_t value) { return value != 0; }))
      continue;
    FoldRows(padded, y + kGaborRadiusPx, folded);
    kFilterRow(
        folded, kWeights, inside, grey.cols, {responses[0][y], responses[1][y], responses[2][y]});
  }
  for (cv::Mat1f& response : responses) response = response.colRange(0, grey.cols);
  return responses;
}

}  // namespace freelsd
