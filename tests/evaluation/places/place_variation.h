// Changes of a photograph that do not change what it shows.
#pragma once

#include <string>
#include <vector>

#include <opencv2/core.hpp>

namespace freelsd {

enum class PlaceVariation {
  kNone,
  // Magenta: blue times 1.10, green times 0.92, red times 1.06.
  kCast,
  // 0.6 times as bright.
  kDark,
  // Gaussian with a deviation of one pixel of the working image.
  kBlur,
  // 0.75 times the photograph plus 45 grey levels.
  kHaze,
};

// "none", "cast", "dark", "blur" or "haze". Throws std::invalid_argument for another name.
PlaceVariation PlaceVariationNamed(const std::string& name);
const std::vector<std::string>& PlaceVariationNames();

// px_per_working_px: pixels of the photograph per pixel of the working image.
cv::Mat3b Varied(const cv::Mat3b& photograph, PlaceVariation variation, double px_per_working_px);

}  // namespace freelsd
