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

// Shares of a pixel smaller than this are rounding, as OpenCV takes it.
constexpr double kLeastShare = 1e-3;
// A pixel of three channels is worked on in one register of four.
constexpr int kRegisterFloats = 4;
typedef float Register __attribute__((vector_size(kRegisterFloats * sizeof(float))));

// Source pixels that one pixel of the result covers, along one axis: the first and the last may be
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

// Those of all pixels along an axis, with equally many weights: where there are fewer, zeros
// follow, which change no sum.
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

// Rows of the source that are added up in one pass.
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

// Weighted sums down the columns. `sums` is longer than the rows.
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
      // A weight of 0 may stand for a row below the last.
      rows[k] = image.ptr<uint8_t>(std::min(first + static_cast<int>(at + k), image.rows - 1));
    }
    AddRows(rows, weights + at, num_rows, length, sums.data());
  }
}

// Weighted sums along a row. Both rows have kRegisterFloats more than they need.
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

// To the nearest, halves to the even one. Values in 0..255.
FREELSD_SEVERAL_TARGETS void RoundRow(const float* __restrict__ values,
                                      int length,
                                      uint8_t* __restrict__ rounded) {
  // Between it and twice it floats are the whole numbers.
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
  // The last pixels are read and written as if others followed.
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
