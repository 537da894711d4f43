#include "engine/stereo/window_correlation.h"

#include <utility>

#include <doctest/doctest.h>
#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

cv::Mat1f Mean(const cv::Mat1f& image, int window_px) {
  cv::Mat1f mean;
  cv::blur(image, mean, {window_px, window_px});
  return mean;
}

// The same from means of whole images.
cv::Mat1b OfMeans(const cv::Mat1b& grey_a, const cv::Mat1b& grey_b, const CorrelationOptions& o) {
  const cv::Mat1f a(grey_a), b(grey_b);
  const cv::Mat1f mean_a = Mean(a, o.window_px), mean_b = Mean(b, o.window_px);
  const cv::Mat1f variance_a = Mean(a.mul(a), o.window_px) - mean_a.mul(mean_a);
  const cv::Mat1f variance_b = Mean(b.mul(b), o.window_px) - mean_b.mul(mean_b);
  const cv::Mat1f covariance = Mean(a.mul(b), o.window_px) - mean_a.mul(mean_b);
  cv::Mat1f deviations;
  cv::sqrt(cv::max(variance_a.mul(variance_b), 0.0), deviations);
  return (variance_a > o.min_variance) & (variance_b > o.min_variance) &
         (covariance > o.min_correlation * deviations);
}

// Smooth noise with an even corner; `b` is `a` with more noise.
std::pair<cv::Mat1b, cv::Mat1b> Images(cv::Size size) {
  cv::RNG random(5);
  cv::Mat1f smooth(size), noise(size);
  random.fill(smooth, cv::RNG::NORMAL, 128.0, 160.0);
  random.fill(noise, cv::RNG::NORMAL, 0.0, 25.0);
  cv::GaussianBlur(smooth, smooth, {}, 2.0);
  smooth(cv::Rect(0, 0, size.width / 2, size.height / 2)) = 90.0F;
  return {cv::Mat1b(smooth), cv::Mat1b(cv::Mat(0.8 * smooth + noise))};
}

TEST_CASE("window correlation: windows are alike where the means of whole images say so") {
  for (const cv::Size size : {cv::Size(160, 120), cv::Size(67, 41)}) {
    const auto [a, b] = Images(size);
    for (const int window_px : {3, 15, 41, 63}) {
      for (const double min_correlation : {0.0, 0.6, 0.95}) {
        for (const double min_variance : {0.0, 2.25, 2.89}) {
          CAPTURE(size.width);
          CAPTURE(window_px);
          CAPTURE(min_correlation);
          CAPTURE(min_variance);
          const CorrelationOptions options{window_px, min_variance, min_correlation};
          CHECK(cv::countNonZero(AlikeWindows(a, b, options) != OfMeans(a, b, options)) == 0);
        }
      }
    }
  }
}

TEST_CASE("window correlation: of some images all windows are alike, of others none") {
  const auto [a, b] = Images({80, 60});
  const cv::Mat1b lower = a.rowRange(45, 60);
  CHECK(cv::countNonZero(AlikeWindows(lower, lower, {7, 1.0, 0.9})) ==
        static_cast<int>(lower.total()));
  CHECK(cv::countNonZero(AlikeWindows(lower, cv::Mat1b(255 - lower), {7, 1.0, 0.0})) == 0);
  const cv::Mat1b even(a.size(), uint8_t{255});
  CHECK(cv::countNonZero(AlikeWindows(even, even, {63, 0.0, 0.0})) == 0);
}

}  // namespace
}  // namespace freelsd
