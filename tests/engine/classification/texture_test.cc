#include "engine/classification/texture.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <doctest/doctest.h>
#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

// Means of the region's log brightness over windows about each pixel, by integral images of all.
cv::Mat1f PlainMeans(const cv::Mat1b& grey, const cv::Mat1b& mask, int side_px) {
  const int margin_px = side_px;
  cv::Mat1f logs(grey.rows + 2 * margin_px, grey.cols + 2 * margin_px, 0.0f);
  cv::Mat1b inside(logs.size(), uint8_t{0});
  for (int y = 0; y < grey.rows; ++y) {
    for (int x = 0; x < grey.cols; ++x) {
      if (mask(y, x) == 0) continue;
      logs(y + margin_px, x + margin_px) = std::log(static_cast<float>(grey(y, x)) + 4.0f);
      inside(y + margin_px, x + margin_px) = 1;
    }
  }
  cv::Mat1d sums;
  cv::Mat1i counts;
  cv::integral(logs, sums, CV_64F);
  cv::integral(inside, counts, CV_32S);
  const auto over_window = [&](const auto& integral, int top, int left) {
    const int bottom = top + side_px, right = left + side_px;
    return integral(bottom, right) - integral(bottom, left) - integral(top, right) +
           integral(top, left);
  };
  cv::Mat1f means(grey.size());
  for (int y = 0; y < grey.rows; ++y) {
    for (int x = 0; x < grey.cols; ++x) {
      const int top = y + margin_px - side_px / 2, left = x + margin_px - side_px / 2;
      means(y, x) = static_cast<float>(over_window(sums, top, left)) /
                    static_cast<float>(std::max(over_window(counts, top, left), 1));
    }
  }
  return means;
}

// Of the region's pixels, row by row.
std::vector<float> Differences(const cv::Mat1f& a, const cv::Mat1f& b, const cv::Mat1b& mask) {
  std::vector<float> differences;
  for (int y = 0; y < mask.rows; ++y) {
    for (int x = 0; x < mask.cols; ++x) {
      if (mask(y, x) != 0) differences.push_back(a(y, x) - b(y, x));
    }
  }
  return differences;
}

constexpr double kTinyDeviation = 0.005;

float PlainLogDeviation(const std::vector<float>& values) {
  double sum = 0.0, sum_of_squares = 0.0;
  for (const double value : values) {
    sum += value;
    sum_of_squares += value * value;
  }
  const auto count = static_cast<double>(std::max<size_t>(values.size(), 1));
  const double mean = sum / count, variance = sum_of_squares / count - mean * mean;
  return static_cast<float>(std::log(std::sqrt(std::max(variance, 0.0)) + kTinyDeviation));
}

float PlainSkewness(std::vector<float> values) {
  if (values.empty()) return 0.0f;
  std::sort(values.begin(), values.end());
  const auto quantile = [&](double share) {
    return values[static_cast<size_t>(share * static_cast<double>(values.size() - 1))];
  };
  const float lower = quantile(0.05), median = quantile(0.5), upper = quantile(1.0 - 0.05);
  return (upper + lower - 2.0f * median) /
         (upper - lower + 2.0f * static_cast<float>(kTinyDeviation));
}

Texture PlainTexture(const cv::Mat1b& grey,
                     const cv::Mat1b& mask,
                     double ground_sampling_distance_m) {
  const auto means = [&](double side_m) {
    return PlainMeans(grey, mask, std::max(1, cvRound(side_m / ground_sampling_distance_m)));
  };
  const cv::Mat1f leaf = means(0.6), tuft = means(1.8), bush = means(4.2);
  return {PlainLogDeviation(Differences(leaf, tuft, mask)),
          PlainLogDeviation(Differences(tuft, bush, mask)),
          PlainSkewness(Differences(means(0.3), means(0.9), mask))};
}

void CheckAgainstPlain(const cv::Mat1b& grey, const cv::Mat1b& mask) {
  for (const double ground_sampling_distance_m : {0.02, 0.11, 0.3, 0.42, 1.0, 5.0}) {
    CAPTURE(grey.size());
    CAPTURE(ground_sampling_distance_m);
    const Texture expected = PlainTexture(grey, mask, ground_sampling_distance_m);
    const Texture texture = TextureOf(grey, mask, ground_sampling_distance_m);
    CHECK(texture.leaf_log_deviation == expected.leaf_log_deviation);
    CHECK(texture.tuft_log_deviation == expected.tuft_log_deviation);
    CHECK(texture.gap_skewness == expected.gap_skewness);
  }
}

const cv::Size kSizes[] = {{67, 45}, {130, 9}, {1, 40}, {53, 1}, {1, 1}, {2, 3}};

TEST_CASE("texture: integral images of the whole region and sorting give the same numbers") {
  cv::RNG random(21);
  for (const cv::Size& size : kSizes) {
    cv::Mat1b grey(size), numbers(size);
    random.fill(grey, cv::RNG::UNIFORM, 0, 256);
    random.fill(numbers, cv::RNG::UNIFORM, 0, 256);
    cv::Mat1b disc(size, uint8_t{0});
    cv::circle(disc, {size.width / 2, size.height / 2}, size.height / 3, 255, cv::FILLED);
    CheckAgainstPlain(grey, cv::Mat1b(size, uint8_t{255}));
    CheckAgainstPlain(grey, numbers < 100);
    CheckAgainstPlain(grey, disc);
  }
}

TEST_CASE("texture: black, white, half white, and no region at all") {
  for (const cv::Size& size : kSizes) {
    const cv::Mat1b all(size, uint8_t{255}), none(size, uint8_t{0});
    cv::Mat1b half = none.clone();
    half.colRange(size.width / 2, size.width) = 255;
    for (const cv::Mat1b& grey : {all, none, half}) {
      CheckAgainstPlain(grey, all);
      CheckAgainstPlain(grey, none);
    }
  }
}

}  // namespace
}  // namespace freelsd
