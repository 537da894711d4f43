// What of a picture does not depend on the light, and how it is averaged.
#pragma once

#include <opencv2/core.hpp>

namespace freelsd {

// Mean over a square of the pixels that count; 0 where none does.
cv::Mat1f MaskedMean(const cv::Mat1f& values, const cv::Mat1b& counts, int side_px);

// Natural logarithms. Unlike brightness, green_excess is nearly the same in the sun, in the shade
// and under clouds: the light of sun and sky differs in blue against red.
struct LightBands {
  cv::Mat1f brightness;
  // Green against the mean of red and blue.
  cv::Mat1f green_excess;
  // Red against blue.
  cv::Mat1f red_blue;
  // Deviations of their noise.
  cv::Mat1f brightness_noise, green_noise, red_blue_noise;
};
LightBands BandsOf(const cv::Mat3f& picture, double noise_grey);

// A band against its surroundings, in deviations of the surroundings: the pattern of the ground in
// any light. Patterns fainter than `faintest` remain faint. 0 where unknown.
cv::Mat1f PatternOf(const cv::Mat1f& band, const cv::Mat1b& is_shown, int side_px, float faintest);

}  // namespace freelsd
