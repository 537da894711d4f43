// Pictures as PNG.
#pragma once

#include <array>
#include <string>

#include <opencv2/core.hpp>

namespace freelsd {

// `image` is 8 bit BGR or BGRA with at least one pixel; else std::invalid_argument is thrown.
std::string EncodePng(const cv::Mat& image);
// For pictures that are made on request: a third of the time, some more bytes. An opaque picture is
// written without alpha. `picture` is BGRA.
std::string EncodePngQuickly(const cv::Mat4b& picture);
// `indices` are positions in the palette, which is BGRA. At least one pixel, as above.
std::string EncodePalettePng(const cv::Mat1b& indices, const std::array<cv::Vec4b, 256>& palette);

}  // namespace freelsd
