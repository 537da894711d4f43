#include "engine/watch/light_bands.h"

#include <cmath>

#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

// Keeps logarithms of black pixels finite, grey levels.
constexpr float kDarkest = 4.0f;
// Pixels that stand out more than this count like this: one thing must not outweigh the ground.
constexpr float kStrongestPattern = 2.5f;

cv::Mat1f BoxSumOf(const cv::Mat1f& values, int side_px) {
  cv::Mat1f sum;
  cv::boxFilter(values, sum, CV_32F, {side_px, side_px}, {-1, -1}, false, cv::BORDER_CONSTANT);
  return sum;
}

}  // namespace

cv::Mat1f MaskedMean(const cv::Mat1f& values, const cv::Mat1b& counts, int side_px) {
  cv::Mat1f weight, product;
  counts.convertTo(weight, CV_32F, 1.0 / 255.0);
  cv::multiply(values, weight, product);
  const cv::Mat1f sum = BoxSumOf(product, side_px);
  const cv::Mat1f weights = BoxSumOf(weight, side_px);
  cv::Mat1f mean = sum / cv::max(weights, 0.5f);
  mean.setTo(0.0f, weights < 0.5f);
  return mean;
}

LightBands BandsOf(const cv::Mat3f& picture, double noise_grey) {
  LightBands bands;
  for (cv::Mat1f* band : {&bands.brightness,
                          &bands.green_excess,
                          &bands.red_blue,
                          &bands.brightness_noise,
                          &bands.green_noise,
                          &bands.red_blue_noise}) {
    band->create(picture.size());
  }
  const float noise = static_cast<float>(noise_grey);
  for (int row = 0; row < picture.rows; ++row) {
    for (int col = 0; col < picture.cols; ++col) {
      const cv::Vec3f color = picture(row, col) + cv::Vec3f::all(kDarkest);
      const float blue = std::log(color[0]), green = std::log(color[1]), red = std::log(color[2]);
      const float sum = color[0] + color[1] + color[2];
      bands.brightness(row, col) = std::log(sum / 3.0f);
      bands.green_excess(row, col) = green - 0.5f * (blue + red);
      bands.red_blue(row, col) = red - blue;
      bands.brightness_noise(row, col) = noise * std::sqrt(3.0f) / sum;
      const float b = 0.5f / color[0], g = 1.0f / color[1], r = 0.5f / color[2];
      bands.green_noise(row, col) = noise * std::sqrt(b * b + g * g + r * r);
      bands.red_blue_noise(row, col) = 2.0f * noise * std::sqrt(b * b + r * r);
    }
  }
  return bands;
}

cv::Mat1f PatternOf(const cv::Mat1f& band, const cv::Mat1b& is_shown, int side_px, float faintest) {
  const cv::Mat1f offset = band - MaskedMean(band, is_shown, side_px);
  const cv::Mat1f variance = MaskedMean(offset.mul(offset), is_shown, side_px);
  cv::Mat1f deviation;
  cv::sqrt(variance + faintest * faintest, deviation);
  cv::Mat1f pattern = offset / deviation;
  pattern = cv::max(cv::min(pattern, kStrongestPattern), -kStrongestPattern);
  pattern.setTo(0.0f, is_shown == 0);
  return pattern;
}

}  // namespace freelsd
