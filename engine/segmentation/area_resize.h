// Private to segmentation/. A smaller image whose pixels are means over what they cover.
#pragma once

#include <opencv2/core.hpp>

namespace freelsd {

// As cv::resize with INTER_AREA, but for rounding and faster. 8 bit, one or three channels; `size`
// larger than the image in neither direction.
cv::Mat ReduceByArea(const cv::Mat& image, cv::Size size);

}  // namespace freelsd
