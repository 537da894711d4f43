#include "engine/stereo/window_correlation.h"

#include <cmath>
#include <cstdint>
#include <numeric>
#include <vector>

#include <opencv2/core/hal/hal.hpp>
#include <opencv2/imgproc.hpp>

#include "engine/geometry/geometry.h"

namespace freelsd {
namespace {

// Grey levels and their products, summed over the rows of a window, or over windows. Integers, so
// that sums are exact.
struct Sums {
  std::vector<int32_t> a, b, aa, bb, ab;

  explicit Sums(int num_cols) : a(static_cast<size_t>(num_cols), 0), b(a), aa(a), bb(a), ab(a) {}
};

// Two rows of factors.
struct Factors {
  const uint8_t* a;
  const uint8_t* b;
};

FREELSD_SEVERAL_TARGETS void Move(Factors entering,
                                  Factors leaving,
                                  int num_cols,
                                  int32_t* __restrict__ sums) {
  for (int i = 0; i < num_cols; ++i)
    sums[i] += entering.a[i] * entering.b[i] - leaving.a[i] * leaving.b[i];
}

// Turns sums over columns into sums over windows. `columns` has one more entry at its end.
void SumAlong(const Sums& columns, int window_px, int num_cols, Sums& windows) {
  for (const auto sums : {&Sums::a, &Sums::b, &Sums::aa, &Sums::bb, &Sums::ab}) {
    const int32_t* __restrict__ from = (columns.*sums).data();
    int32_t* __restrict__ to = (windows.*sums).data();
    int32_t sum = std::accumulate(from, from + window_px, 0);
    for (int i = 0; i < num_cols; ++i) {
      to[i] = sum;
      sum += from[i + window_px] - from[i];
    }
  }
}

FREELSD_SEVERAL_TARGETS void Scale(const int32_t* __restrict__ sums,
                                   int count,
                                   double scale,
                                   float* __restrict__ means) {
  for (int i = 0; i < count; ++i) means[i] = static_cast<float>(sums[i] * scale);
}

// Means of the products, minus the products of the means.
FREELSD_SEVERAL_TARGETS void Center(const float* __restrict__ means_a,
                                    const float* __restrict__ means_b,
                                    int count,
                                    float* __restrict__ products) {
  for (int i = 0; i < count; ++i) products[i] -= means_a[i] * means_b[i];
}

FREELSD_SEVERAL_TARGETS void Multiply(const float* __restrict__ a,
                                      const float* __restrict__ b,
                                      int count,
                                      float* __restrict__ products) {
  // Negative only if one variance is negative. Such a window has too little variance in any case.
  for (int i = 0; i < count; ++i) products[i] = std::abs(a[i] * b[i]);
}

struct Statistics {
  std::vector<float> mean_a, mean_b, variance_a, variance_b, covariance, deviations;

  explicit Statistics(int num_cols)
      : mean_a(static_cast<size_t>(num_cols)),
        mean_b(mean_a),
        variance_a(mean_a),
        variance_b(mean_a),
        covariance(mean_a),
        deviations(mean_a) {}
};

void Describe(const Sums& windows, int window_px, Statistics& of) {
  const auto num_cols = static_cast<int>(windows.a.size());
  const double scale = 1.0 / (window_px * window_px);
  Scale(windows.a.data(), num_cols, scale, of.mean_a.data());
  Scale(windows.b.data(), num_cols, scale, of.mean_b.data());
  Scale(windows.aa.data(), num_cols, scale, of.variance_a.data());
  Scale(windows.bb.data(), num_cols, scale, of.variance_b.data());
  Scale(windows.ab.data(), num_cols, scale, of.covariance.data());
  Center(of.mean_a.data(), of.mean_a.data(), num_cols, of.variance_a.data());
  Center(of.mean_b.data(), of.mean_b.data(), num_cols, of.variance_b.data());
  Center(of.mean_a.data(), of.mean_b.data(), num_cols, of.covariance.data());
  Multiply(of.variance_a.data(), of.variance_b.data(), num_cols, of.deviations.data());
  cv::hal::sqrt32f(of.deviations.data(), of.deviations.data(), num_cols);
}

FREELSD_SEVERAL_TARGETS void Compare(const Statistics& of,
                                     int num_cols,
                                     const CorrelationOptions& options,
                                     uint8_t* __restrict__ are_alike) {
  const auto min_variance = static_cast<float>(options.min_variance);
  const auto min_correlation = static_cast<float>(options.min_correlation);
  const float *variance_a = of.variance_a.data(), *variance_b = of.variance_b.data();
  const float *covariance = of.covariance.data(), *deviations = of.deviations.data();
  for (int i = 0; i < num_cols; ++i) {
    const int are = static_cast<int>(variance_a[i] > min_variance) &
                    static_cast<int>(variance_b[i] > min_variance) &
                    static_cast<int>(covariance[i] > min_correlation * deviations[i]);
    are_alike[i] = static_cast<uint8_t>(-are);
  }
}

// Mirrored at its own borders, even if it is part of a larger image.
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
  const auto num_cols = static_cast<size_t>(framed_a.cols);
  const std::vector<uint8_t> black(num_cols, 0), ones(num_cols, 1);
  Sums columns(framed_a.cols + 1), windows(a.cols);
  Statistics statistics(a.cols);
  const auto move = [&](const Factors& entering, const Factors& leaving) {
    const uint8_t* one = ones.data();
    Move({entering.a, one}, {leaving.a, one}, framed_a.cols, columns.a.data());
    Move({entering.b, one}, {leaving.b, one}, framed_a.cols, columns.b.data());
    Move({entering.a, entering.a}, {leaving.a, leaving.a}, framed_a.cols, columns.aa.data());
    Move({entering.b, entering.b}, {leaving.b, leaving.b}, framed_a.cols, columns.bb.data());
    Move(entering, leaving, framed_a.cols, columns.ab.data());
  };
  const auto rows = [&](int y) { return Factors{framed_a[y], framed_b[y]}; };
  cv::Mat1b are_alike(a.size());
  for (int y = 0; y < window_px; ++y) move(rows(y), {black.data(), black.data()});
  for (int y = 0; y < a.rows; ++y) {
    if (y > 0) move(rows(y + window_px - 1), rows(y - 1));
    SumAlong(columns, window_px, a.cols, windows);
    Describe(windows, window_px, statistics);
    Compare(statistics, a.cols, options, are_alike[y]);
  }
  return are_alike;
}

}  // namespace freelsd
