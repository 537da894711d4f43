#include "engine/segmentation/area_resize.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include <opencv2/imgproc.hpp>

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

std::vector<Cover> CoversOf(int length, int source_length) {
  const double scale = static_cast<double>(source_length) / length;
  std::vector<Cover> covers;
  for (int i = 0; i < length; ++i) covers.push_back(CoverOf(i, scale, source_length));
  return covers;
}

[[gnu::always_inline]] inline void AddRow(const uint8_t* row,
                                          float weight,
                                          int length,
                                          float* sums) {
  for (int i = 0; i < length; ++i) sums[i] += weight * static_cast<float>(row[i]);
}

using RowAdder = void (*)(const uint8_t*, float, int, float*);

void AddRowPlain(const uint8_t* row, float weight, int length, float* sums) {
  AddRow(row, weight, length, sums);
}

#if defined(__x86_64__)
// Without fused multiplications: every processor has the same rounding.
[[gnu::target("avx2")]] void AddRowAvx2(const uint8_t* row, float weight, int length, float* sums) {
  AddRow(row, weight, length, sums);
}

RowAdder FastestRowAdder() {
  return __builtin_cpu_supports("avx2") != 0 ? AddRowAvx2 : AddRowPlain;
}
#else
RowAdder FastestRowAdder() { return AddRowPlain; }
#endif

// Weighted sums along a row; `sums` has kRegisterFloats more than it needs.
void ReduceRow(const std::vector<float>& sums,
               const std::vector<Cover>& covers,
               int num_channels,
               uint8_t* result) {
  for (const Cover& cover : covers) {
    const float* pixel = sums.data() + static_cast<ptrdiff_t>(cover.first) * num_channels;
    Register sum = {};
    for (const float weight : cover.weights) {
      Register value;
      std::memcpy(&value, pixel, sizeof(Register));
      sum += weight * value;
      pixel += num_channels;
    }
    for (int channel = 0; channel < num_channels; ++channel) {
      *result++ = cv::saturate_cast<uint8_t>(sum[channel]);
    }
  }
}

}  // namespace

cv::Mat ReduceByArea(const cv::Mat& image, cv::Size size) {
  static const RowAdder kAddRow = FastestRowAdder();
  const int num_channels = image.channels(), length = image.cols * num_channels;
  cv::Mat reduced(size, image.type());
  const std::vector<Cover> rows = CoversOf(size.height, image.rows);
  const std::vector<Cover> cols = CoversOf(size.width, image.cols);
  std::vector<float> sums(static_cast<size_t>(length) + kRegisterFloats);
  for (int y = 0; y < size.height; ++y) {
    std::fill(sums.begin(), sums.end(), 0.0f);
    int source = rows[static_cast<size_t>(y)].first;
    for (const float weight : rows[static_cast<size_t>(y)].weights) {
      kAddRow(image.ptr<uint8_t>(source++), weight, length, sums.data());
    }
    ReduceRow(sums, cols, num_channels, reduced.ptr<uint8_t>(y));
  }
  return reduced;
}

}  // namespace freelsd
