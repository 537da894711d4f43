// Private to layers/. Colours of layer pictures.
#pragma once

#include <string>

#include "api/export/layers/layers.h"

namespace freelsd {

// RGB, 0..255.
using Color = cv::Vec3b;

// Colours that no ramp contains. They differ in brightness, so colour-blind people can distinguish
// them.
const Color kFreeColor(126, 211, 150);
const Color kHazardColor(200, 70, 0);
const Color kUnseenColor(26, 26, 26);

// Values of a layer at the two ends of its ramp. For slope, roughness and grass they are fixed, so
// that pictures of different sites are comparable; for other layers they depend on the seen values.
struct Scale {
  double min = 0.0;
  double max = 1.0;
};
Scale ScaleOf(const SiteMap& site_map, const std::string& name);

// Colour at a position of the layer's ramp. `share` is 0 to 1; other values are clamped.
Color RampColor(const std::string& name, double share);

}  // namespace freelsd
