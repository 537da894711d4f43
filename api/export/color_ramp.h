// Private to export/. Colours of the layers' pictures.
#pragma once

#include <string>

#include "api/export/export.h"

namespace freelsd {

// RGB, 0..255.
using Color = cv::Vec3b;

// Told apart by brightness alone, so by everyone; none lies on a ramp.
const Color kFreeColor(126, 211, 150);
const Color kHazardColor(200, 70, 0);
const Color kUnseenColor(26, 26, 26);

// Values of a layer that the ends of its ramp stand for. Fixed where a limit is to be compared
// between sites (slope, roughness, grass), else from the seen values.
struct Scale {
  double min = 0.0;
  double max = 1.0;
};
Scale ScaleOf(const SiteMap& site_map, const std::string& name);

// Colour of a share 0..1 of the layer's ramp; clamped.
Color RampColor(const std::string& name, double share);

}  // namespace freelsd
