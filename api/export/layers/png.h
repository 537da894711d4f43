// Pictures as PNG.
#pragma once

#include <string>

#include <opencv2/core.hpp>

namespace freelsd {

// `image` is 8 bit BGR or BGRA with at least one pixel; else std::invalid_argument is thrown.
std::string EncodePng(const cv::Mat& image);

}  // namespace freelsd
