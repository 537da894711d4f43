// Pictures as PNG.
#pragma once

#include <string>

#include <opencv2/core.hpp>

namespace freelsd {

// Of 8 bit BGR or BGRA, at least one pixel; throws std::invalid_argument on anything else.
std::string EncodePng(const cv::Mat& image);

}  // namespace freelsd
