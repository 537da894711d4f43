#include "api/export/color_ramp.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/ground_kind/ground_kind.h"

namespace freelsd {
namespace {

// Cividis (Nunez et al. 2018): brightness rises evenly for normal and for colour-blind vision.
constexpr std::array<std::array<uint8_t, 3>, 10> kCividis{{{0, 34, 78},
                                                           {18, 53, 112},
                                                           {59, 73, 108},
                                                           {87, 93, 109},
                                                           {112, 113, 115},
                                                           {138, 134, 120},
                                                           {165, 156, 116},
                                                           {195, 179, 105},
                                                           {225, 204, 85},
                                                           {254, 232, 56}}};
// Brown, white, teal (ColorBrewer BrBG).
constexpr std::array<std::array<uint8_t, 3>, 5> kBrownTeal{
    {{140, 81, 10}, {216, 179, 101}, {245, 245, 245}, {90, 180, 172}, {1, 102, 94}}};
// By GroundKind: grass, rough, crop, stubble, soil, sand, tree, water, sealed, snow.
constexpr std::array<std::array<uint8_t, 3>, kNumGroundKinds> kKindColors{{{102, 194, 82},
                                                                           {154, 160, 60},
                                                                           {196, 222, 60},
                                                                           {232, 206, 112},
                                                                           {140, 96, 62},
                                                                           {240, 228, 180},
                                                                           {22, 92, 46},
                                                                           {52, 120, 200},
                                                                           {130, 130, 138},
                                                                           {250, 250, 255}}};
// Start of the ramps of free ground. It must be brighter than unseen ground.
constexpr double kFreeRampStart = 0.35;
template <size_t n>
Color Interpolate(const std::array<std::array<uint8_t, 3>, n>& colors, double share) {
  const double position = std::clamp(share, 0.0, 1.0) * (n - 1);
  const size_t index = std::min(n - 2, static_cast<size_t>(position));
  const double part = position - static_cast<double>(index);
  Color color;
  for (int channel = 0; channel < 3; ++channel) {
    color[channel] = static_cast<uint8_t>(
        std::lround((1.0 - part) * colors[index][channel] + part * colors[index + 1][channel]));
  }
  return color;
}

}  // namespace

cv::Vec4b Bgra(const Color& color) {
  constexpr uint8_t kOpaque = 255;
  return {color[2], color[1], color[0], kOpaque};
}

Color RampColor(const std::string& name, double share) {
  if (name == "kind") {
    const auto kind = static_cast<int>(std::floor(share * kNumGroundKinds));
    const auto& [red, green, blue] =
        kKindColors[static_cast<size_t>(std::clamp(kind, 0, kNumGroundKinds - 1))];
    return {red, green, blue};
  }
  if (name == "grass") return Interpolate(kBrownTeal, share);
  if (name == "distance" || name == "risk") {
    // The brighter the safer.
    const double safe = std::clamp(name == "risk" ? 1.0 - share : share, 0.0, 1.0);
    return Interpolate(kCividis, kFreeRampStart + (1.0 - kFreeRampStart) * safe);
  }
  return Interpolate(kCividis, share);
}

}  // namespace freelsd
