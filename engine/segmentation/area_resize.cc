#include "engine/segmentation/area_resize.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <vector>

#include "engine/geometry/geometry.h"

namespace freelsd {
namespace {

// Smaller shares of a pixel count as rounding errors, as in OpenCV.
constexpr double kLeastShare = 1e-3;
// A pixel of three channels occupies one register of four.
constexpr int kRegisterFloats = 4;
typedef float Register __attribute__((vector_size(kRegisterFloats * sizeof(float))));

// Source pixels under one pixel of the result, along one axis. The first and the last may be
// covered in part.
struct Cover {
  int first = 0;
  std::vector<float> weights;
};

Cover CoverOf(int index, double scale, int source_length) {
  const double from = index * scale, to = from + scale;
  const double width = std::min(scale, source_length - from);
  const int last_whole = std::min(static_cast<int>(std::floor(to)), source_length - 1);
  const int first_whole = std::min(static_cast<int>(std::ceil(from)), last_whole);
  Cover cover{first_whole, {}};
  if (first_whole - from > kLeastShare) {
    cover.first = first_whole - 1;
    cover.weights.push_back(static_cast<float>((first_whole - from) / width));
  }
  for (int i = first_whole; i < last_whole; ++i) {
    cover.weights.push_back(static_cast<float>(1.0 / width));
  }
  if (to - last_whole > kLeastShare) {
    cover.weights.push_back(
        static_cast<float>(std::min(std::min(to - last_whole, 1.0), width) / width));
  }
  return cover;
}

// Covers of all pixels along an axis, each with the same number of weights. Missing weights are 0
// and change no sum.
struct Covers {
  size_t num_weights = 0;
  std::vector<int> first;
  std::vector<float> weights;
};

Covers CoversOf(int length, int source_length) {
  const double scale = static_cast<double>(source_length) / length;
  std::vector<Cover> covers;
  size_t num_weights = 0;
  for (int i = 0; i < length; ++i) {
    covers.push_back(CoverOf(i, scale, source_length));
    num_weights = std::max(num_weights, covers.back().weights.size());
  }
  Covers result{num_weights, {}, {}};
  for (Cover& cover : covers) {
    cover.weights.resize(num_weights);
    result.first.push_back(cover.first);
    result.weights.insert(result.weights.end(), cover.weights.begin(), cover.weights.end());
  }
  return result;
}

// Source rows added per pass.
constexpr size_t kMaxRowsTogether = 4;
using Rows = std::array<const uint8_t*, kMaxRowsTogether>;

template <size_t num_rows>
[[gnu::always_inline]] inline void AddSoMany(const Rows& rows,
                                             const float* weights,
                                             int length,
                                             float* __restrict__ sums) {
  for (int i = 0; i < length; ++i) {
    float sum = sums[i];
    for (size_t k = 0; k < num_rows; ++k) sum += weights[k] * static_cast<float>(rows[k][i]);
    sums[i] = sum;
  }
}

FREELSD_SEVERAL_TARGETS void AddRows(
    const Rows& rows, const float* weights, size_t num_rows, int length, float* sums) {
  if (num_rows == 1) AddSoMany<1>(rows, weights, length, sums);
  if (num_rows == 2) AddSoMany<2>(rows, weights, length, sums);
  if (num_rows == 3) AddSoMany<3>(rows, weights, length, sums);
  if (num_rows == 4) AddSoMany<4>(rows, weights, length, sums);
}

// Weighted sums down the columns. `sums` must be longer than the rows.
void SumRows(const cv::Mat& image,
             int first,
             const float* weights,
             size_t num_weights,
             std::vector<float>& sums) {
  const int length = image.cols * image.channels();
  std::fill(sums.begin(), sums.end(), 0.0f);
  for (size_t at = 0; at < num_weights; at += kMaxRowsTogether) {
    const size_t num_rows = std::min(kMaxRowsTogether, num_weights - at);
    Rows rows{};
    for (size_t k = 0; k < num_rows; ++k) {
      // A weight of 0 may belong to a row below the last.
      rows[k] = image.ptr<uint8_t>(std::min(first + static_cast<int>(at + k), image.rows - 1));
    }
    AddRows(rows, weights + at, num_rows, length, sums.data());
  }
}

// Weighted sums along a row. Both rows have kRegisterFloats extra entries.
FREELSD_SEVERAL_TARGETS void ReduceRow(const float* __restrict__ sums,
                                       const Covers& covers,
                                       int num_channels,
                                       float* __restrict__ reduced) {
  const float* weight = covers.weights.data();
  for (const int first : covers.first) {
    const float* pixel = sums + static_cast<ptrdiff_t>(first) * num_channels;
    Register sum = {};
    for (size_t i = 0; i < covers.num_weights; ++i, ++weight, pixel += num_channels) {
      Register value;
      std::memcpy(&value, pixel, sizeof(Register));
      sum += *weight * value;
    }
    std::memcpy(reduced, &sum, sizeof(Register));
    reduced += num_channels;
  }
}

// Rounds to the nearest integer, halves to even. Values in 0..255.
FREELSD_SEVERAL_TARGETS void RoundRow(const float* __restrict__ values,
                                      int length,
                                      uint8_t* __restrict__ rounded) {
  // From this value up to twice this value, floats are exactly the integers.
  constexpr float kWhole = 8388608.0f;
  for (int i = 0; i < length; ++i) {
    rounded[i] = static_cast<uint8_t>(std::bit_cast<uint32_t>(values[i] + kWhole));
  }
}

}  // namespace

cv::Mat ReduceByArea(const cv::Mat& image, cv::Size size) {
  const int num_channels = image.channels();
  cv::Mat reduced(size, image.type());
  const Covers rows = CoversOf(size.height, image.rows);
  const Covers cols = CoversOf(size.width, image.cols);
  // Padding, because registers read and write past the last pixels.
  const size_t spare = cols.num_weights * static_cast<size_t>(num_channels) + kRegisterFloats;
  std::vector<float> sums(static_cast<size_t>(image.cols * num_channels) + spare);
  std::vector<float> means(static_cast<size_t>(size.width * num_channels) + kRegisterFloats);
  for (int y = 0; y < size.height; ++y) {
    const float* weights = rows.weights.data() + static_cast<size_t>(y) * rows.num_weights;
    SumRows(image, rows.first[static_cast<size_t>(y)], weights, rows.num_weights, sums);
    ReduceRow(sums.data(), cols, num_channels, means.data());
    RoundRow(means.data(), size.width * num_channels, reduced.ptr<uint8_t>(y));
  }
  return reduced;
}

}  // namespace freelsd
