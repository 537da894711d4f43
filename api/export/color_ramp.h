// Private to export/. Colours of layer pictures.
#pragma once

#include <string>

#include <opencv2/core.hpp>

namespace freelsd {

// RGB, 0..255.
using Color = cv::Vec3b;

// Colours that no ramp contains. They differ in brightness, so colour-blind people can distinguish
// them.
const Color kFreeColor(126, 211, 150);
const Color kHazardColor(200, 70, 0);
const Color kUnseenColor(26, 26, 26);

// Opaque, in OpenCV's order of channels.
cv::Vec4b Bgra(const Color& color);

// Colour at a position of the layer's ramp. `share` is 0 to 1; other values are clamped.
Color RampColor(const std::string& name, double share);

}  // namespace freelsd
