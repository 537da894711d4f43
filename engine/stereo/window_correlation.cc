#include "engine/stereo/window_correlation.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "engine/geometry/geometry.h"

namespace freelsd {
namespace {

// Grey levels and their products, summed up over as many rows as a window has or over windows.
// Whole numbers: they sum up exactly.
struct Sums {
  std::vector<int32_t> a, b, aa, bb, ab;

  explicit Sums(int num_cols) : a(static_cast<size_t>(num_cols), 0), b(a), aa(a), bb(a), ab(a) {}
};

struct GreyRows {
  const uint8_t* a;
  const uint8_t* b;
};

FREELSD_SEVERAL_TARGETS void Add(GreyRows rows, int num_cols, int sign, Sums& sums) {
  const uint8_t* __restrict__ a = rows.a;
  const uint8_t* __restrict__ b = rows.b;
  int32_t* __restrict__ sum_a = sums.a.data();
  int32_t* __restrict__ sum_b = sums.b.data();
  int32_t* __restrict__ sum_aa = sums.aa.data();
  int32_t* __restrict__ sum_bb = sums.bb.data();
  int32_t* __restrict__ sum_ab = sums.ab.data();
  for (int i = 0; i < num_cols; ++i) {
    const int of_a = sign * a[i], of_b = sign * b[i];
    sum_a[i] += of_a;
    sum_b[i] += of_b;
    sum_aa[i] += of_a * a[i];
    sum_bb[i] += of_b * b[i];
    sum_ab[i] += of_a * b[i];
  }
}

// From sums over columns to sums over windows.
void SumAlong(const Sums& columns, int window_px, int num_cols, Sums& windows) {
  for (const auto sums : {&Sums::a, &Sums::b, &Sums::aa, &Sums::bb, &Sums::ab}) {
    const std::vector<int32_t>& from = columns.*sums;
    std::vector<int32_t>& to = windows.*sums;
    int32_t sum = 0;
    for (int i = 0; i < window_px - 1; ++i) sum += from[static_cast<size_t>(i)];
    for (int i = 0; i < num_cols; ++i) {
      sum += from[static_cast<size_t>(i + window_px - 1)];
      to[static_cast<size_t>(i)] = sum;
      sum -= from[static_cast<size_t>(i)];
    }
  }
}

FREELSD_SEVERAL_TARGETS void Compare(const Sums& windows,
                                     int num_cols,
                                     const CorrelationOptions& options,
                                     uint8_t* __restrict__ are_alike) {
  const double scale = 1.0 / (options.window_px * options.window_px);
  const auto min_variance = static_cast<float>(options.min_variance);
  const auto min_correlation = static_cast<float>(options.min_correlation);
  const int32_t* __restrict__ sum_a = windows.a.data();
  const int32_t* __restrict__ sum_b = windows.b.data();
  const int32_t* __restrict__ sum_aa = windows.aa.data();
  const int32_t* __restrict__ sum_bb = windows.bb.data();
  const int32_t* __restrict__ sum_ab = windows.ab.data();
  for (int i = 0; i < num_cols; ++i) {
    const auto mean_a = static_cast<float>(sum_a[i] * scale);
    const auto mean_b = static_cast<float>(sum_b[i] * scale);
    const float variance_a = static_cast<float>(sum_aa[i] * scale) - mean_a * mean_a;
    const float variance_b = static_cast<float>(sum_bb[i] * scale) - mean_b * mean_b;
    const float covariance = static_cast<float>(sum_ab[i] * scale) - mean_a * mean_b;
    const float product = variance_a * variance_b;
    const float deviations = std::sqrt(product > 0.0F ? product : 0.0F);
    const int are = static_cast<int>(variance_a > min_variance) &
                    static_cast<int>(variance_b > min_variance) &
                    static_cast<int>(covariance > min_correlation * deviations);
    are_alike[i] = static_cast<uint8_t>(-are);
  }
}

// Mirrored at its own borders, even if it is a part of another image.
cv::Mat1b Framed(const cv::Mat1b& image, int width_px) {
  cv::Mat1b framed;
  cv::copyMakeBorder(image,
                     framed,
                     width_px,
                     width_px,
                     width_px,
                     width_px,
                     cv::BORDER_REFLECT_101 | cv::BORDER_ISOLATED);
  return framed;
}

}  // namespace

cv::Mat1b AlikeWindows(const cv::Mat1b& a, const cv::Mat1b& b, const CorrelationOptions& options) {
  const int window_px = options.window_px;
  const cv::Mat1b framed_a = Framed(a, window_px / 2), framed_b = Framed(b, window_px / 2);
  const auto rows = [&](int y) { return GreyRows{framed_a[y], framed_b[y]}; };
  Sums columns(framed_a.cols), windows(a.cols);
  cv::Mat1b are_alike(a.size());
  for (int y = 0; y < window_px - 1; ++y) Add(rows(y), framed_a.cols, 1, columns);
  for (int y = 0; y < a.rows; ++y) {
    Add(rows(y + window_px - 1), framed_a.cols, 1, columns);
    SumAlong(columns, window_px, a.cols, windows);
    Compare(windows, a.cols, options, are_alike[y]);
    Add(rows(y), framed_a.cols, -1, columns);
  }
  return are_alike;
}

}  // namespace freelsd
