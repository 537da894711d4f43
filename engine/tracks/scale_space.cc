#include "engine/tracks/scale_space.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include <opencv2/imgproc.hpp>

#include "engine/tracks/processor_targets.h"

namespace freelsd {
namespace {

// What the lens has blurred already, in pixels of the image.
constexpr double kImageSigmaPx = 0.5;
// Beyond this many deviations the kernel ends.
constexpr double kKernelReach = 4.0;
// Pixels that are summed at a time.
constexpr int kRegisterPx = 8;
constexpr int kNumRegisters = 4;
constexpr int kBlockPx = kRegisterPx * kNumRegisters;
typedef float Register __attribute__((vector_size(kRegisterPx * sizeof(float))));

// Rows are as long as whole blocks, so that sums may reach beyond the last column.
cv::Mat1f PaddedLayer(cv::Size size) {
  const int num_cols = (size.width + kBlockPx - 1) / kBlockPx * kBlockPx;
  cv::Mat1f padded(size.height, num_cols);
  padded.colRange(size.width, num_cols) = 0.0F;
  return padded.colRange(0, size.width);
}

// Upper half of a Gaussian kernel: weights[0] is the middle.
std::vector<float> GaussianWeights(double sigma_px) {
  const int side = static_cast<int>(std::lround(sigma_px * kKernelReach * 2.0 + 1.0)) | 1;
  const cv::Mat1d kernel = cv::getGaussianKernel(side, sigma_px, CV_64F);
  std::vector<float> weights;
  for (int i = side / 2; i < side; ++i) weights.push_back(static_cast<float>(kernel(i)));
  return weights;
}

// sums[x] = sum over j of weights[j] * (before[j][x] + after[j][x]); before[0] is the middle and
// counts once.
FREELSD_SEVERAL_TARGETS void SumSymmetric(const float* const* before,
                                          const float* const* after,
                                          const float* weights,
                                          int num_weights,
                                          int num_cols,
                                          float* sums) {
  for (int x = 0; x < num_cols; x += kBlockPx) {
    Register block[kNumRegisters];
    for (int k = 0; k < kNumRegisters; ++k) {
      Register middle;
      std::memcpy(&middle, before[0] + x + k * kRegisterPx, sizeof(Register));
      block[k] = weights[0] * middle;
    }
    for (int j = 1; j < num_weights; ++j) {
      for (int k = 0; k < kNumRegisters; ++k) {
        Register one, other;
        std::memcpy(&one, before[j] + x + k * kRegisterPx, sizeof(Register));
        std::memcpy(&other, after[j] + x + k * kRegisterPx, sizeof(Register));
        block[k] += weights[j] * (one + other);
      }
    }
    std::memcpy(sums + x, block, sizeof(block));
  }
}

cv::Mat1f Blurred(const cv::Mat1f& layer, double sigma_px) {
  const std::vector<float> weights = GaussianWeights(sigma_px);
  const int num_weights = static_cast<int>(weights.size()), radius = num_weights - 1;
  const int num_cols = layer.cols;
  const auto mirrored = [](int at, int length) {
    return cv::borderInterpolate(at, length, cv::BORDER_REFLECT_101);
  };
  cv::Mat1f blurred = PaddedLayer(layer.size());
  // One row, summed over its neighbours above and below, and mirrored at both ends.
  std::vector<float> row(static_cast<size_t>(num_cols + 2 * radius + kBlockPx), 0.0F);
  float* summed = row.data() + radius;
  std::vector<const float*> before(weights.size()), after(weights.size());
  for (int y = 0; y < layer.rows; ++y) {
    for (int j = 0; j < num_weights; ++j) {
      before[static_cast<size_t>(j)] = layer[mirrored(y - j, layer.rows)];
      after[static_cast<size_t>(j)] = layer[mirrored(y + j, layer.rows)];
    }
    SumSymmetric(before.data(), after.data(), weights.data(), num_weights, num_cols, summed);
    for (int j = 1; j <= radius; ++j) {
      summed[-j] = summed[mirrored(-j, num_cols)];
      summed[num_cols - 1 + j] = summed[mirrored(num_cols - 1 + j, num_cols)];
    }
    for (int j = 0; j < num_weights; ++j) {
      before[static_cast<size_t>(j)] = summed - j;
      after[static_cast<size_t>(j)] = summed + j;
    }
    SumSymmetric(before.data(), after.data(), weights.data(), num_weights, num_cols, blurred[y]);
  }
  return blurred;
}

cv::Mat1f FirstLayer(const cv::Mat1b& grey) {
  cv::Mat1f exact, doubled = PaddedLayer(grey.size() * 2);
  grey.convertTo(exact, CV_32F);
  cv::resize(exact, doubled, doubled.size(), 0.0, 0.0, cv::INTER_LINEAR);
  const double blurred_already = 2.0 * kImageSigmaPx;
  return Blurred(doubled,
                 std::sqrt(kFirstSigmaPx * kFirstSigmaPx - blurred_already * blurred_already));
}

cv::Mat1f EverySecondPixel(const cv::Mat1f& layer) {
  cv::Mat1f half = PaddedLayer({layer.cols / 2, layer.rows / 2});
  for (int y = 0; y < half.rows; ++y) {
    for (int x = 0; x < half.cols; ++x) half(y, x) = layer(2 * y, 2 * x);
  }
  return half;
}

Octave OctaveFrom(const cv::Mat1f& first) {
  Octave octave;
  octave.layers[0] = first;
  const double step = std::pow(2.0, 1.0 / kNumScalesPerOctave);
  double sigma_px = kFirstSigmaPx;
  for (size_t i = 1; i < octave.layers.size(); ++i) {
    // Variances of blurs after one another add up.
    octave.layers[i] = Blurred(octave.layers[i - 1], sigma_px * std::sqrt(step * step - 1.0));
    sigma_px *= step;
  }
  return octave;
}

}  // namespace

std::vector<Octave> ScaleSpaceOf(const cv::Mat1b& grey, int min_side_px) {
  std::vector<Octave> octaves{OctaveFrom(FirstLayer(grey))};
  while (true) {
    const cv::Mat1f& twice_as_blurred = octaves.back().layers[kNumScalesPerOctave];
    if (std::min(twice_as_blurred.cols, twice_as_blurred.rows) / 2 < min_side_px) return octaves;
    octaves.push_back(OctaveFrom(EverySecondPixel(twice_as_blurred)));
  }
}

}  // namespace freelsd
