#include "engine/classification/gabor.h"

#include <doctest/doctest.h>
#include <opencv2/imgproc.hpp>

#include "engine/geometry/geometry.h"

namespace freelsd {
namespace {

// Grey levels of responses that reach 20000.
constexpr double kToleranceGrey = 0.1;

cv::Mat1f Texture(const cv::Size& size) {
  cv::Mat1f image(size);
  cv::RNG generator(3);
  generator.fill(image, cv::RNG::UNIFORM, 0.0, 255.0);
  cv::GaussianBlur(image, image, {}, 0.7);
  return image;
}

// Twelve filters as published, averaged pixel by pixel.
cv::Mat1f PlainResponse(const cv::Mat1f& grey, double wavelength_px) {
  cv::Mat1d sum(grey.size(), 0.0), values;
  grey.convertTo(values, CV_64F);
  for (int direction = 0; direction < 4; ++direction) {
    cv::Mat1d response;
    cv::filter2D(
        values,
        response,
        CV_64F,
        cv::getGaborKernel({31, 31}, 4.0, kPi * direction / 4.0, wavelength_px, 0.02, 0.0, CV_64F));
    sum += response / 4.0;
  }
  cv::Mat1f mean;
  sum.convertTo(mean, CV_32F);
  return mean;
}

double LargestDifference(const cv::Mat1f& first, const cv::Mat1f& second, const cv::Mat1b& mask) {
  return cv::norm(first, second, cv::NORM_INF, mask);
}

TEST_CASE("gabor: the fast filters answer as twelve plain ones do, but for rounding") {
  // Widths that are and are not whole blocks, and less than the filter.
  for (const cv::Size& size : {cv::Size(64, 50), cv::Size(75, 40), cv::Size(20, 17)}) {
    const cv::Mat1f grey = Texture(size);
    const cv::Mat1b everywhere(size, uint8_t{255});
    const auto responses = GaborResponses(grey, everywhere);
    CHECK(LargestDifference(responses[0], PlainResponse(grey, 0.5), everywhere) < kToleranceGrey);
    CHECK(LargestDifference(responses[1], PlainResponse(grey, 1.0), everywhere) < kToleranceGrey);
    CHECK(LargestDifference(responses[2], PlainResponse(grey, 5.0), everywhere) < kToleranceGrey);
  }
}

TEST_CASE("gabor: a mask leaves the responses inside as they are") {
  const cv::Mat1f grey = Texture({90, 60});
  cv::Mat1b mask(grey.size(), uint8_t{0});
  cv::circle(mask, {60, 30}, 20, 255, cv::FILLED);
  const auto masked = GaborResponses(grey, mask);
  const auto all = GaborResponses(grey, cv::Mat1b(grey.size(), uint8_t{255}));
  for (size_t i = 0; i < masked.size(); ++i) {
    CHECK(LargestDifference(masked[i], all[i], mask) == 0.0);
  }
  for (const cv::Mat1f& response : GaborResponses(grey, cv::Mat1b(grey.size(), uint8_t{0}))) {
    CHECK(cv::countNonZero(response) == 0);
  }
}

}  // namespace
}  // namespace freelsd
