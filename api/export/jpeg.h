// Private to export/. Pictures as JPEG.
#pragma once

#include <string>

#include <opencv2/core.hpp>

namespace freelsd {

// `picture` is BGRA, not premultiplied, with at least one pixel. Its transparent parts become
// white.
std::string EncodeJpeg(const cv::Mat4b& picture);

}  // namespace freelsd
