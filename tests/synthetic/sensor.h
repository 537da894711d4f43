// Private to the renderer: what lens and sensor make of the light that reaches them.
#pragma once

#include <opencv2/core.hpp>

#include "tests/synthetic/renderer.h"

namespace freelsd {

// Blur, darker corners, exposure, noise: 8 bit BGR. `frame_index` chooses noise and exposure.
cv::Mat Expose(const cv::Mat3f& light, const RenderOptions& options, int frame_index);

}  // namespace freelsd
