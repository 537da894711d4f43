#include "api/export/layers/scale.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace freelsd {
namespace {

// Twice the usual limits, so that the limits are at the middle of the ramp.
constexpr double kMaxSlopeDeg = 16.0;
constexpr double kMaxRoughnessM = 1.0;
// Share of the heights beyond each end of the ramp. Else a few trees would hide the relief.
constexpr double kTailShare = 0.01;

Scale ScaleOfHeights(const cv::Mat1f& elevation) {
  std::vector<float> heights;
  std::copy_if(elevation.begin(), elevation.end(), std::back_inserter(heights), [](float height) {
    return std::isfinite(height);
  });
  if (heights.empty()) return {};
  std::sort(heights.begin(), heights.end());
  const auto tail = static_cast<size_t>(kTailShare * static_cast<double>(heights.size()));
  const double low = heights[tail], high = heights[heights.size() - 1 - tail];
  return {low, std::max(high, low + 1.0)};
}

}  // namespace

Scale ScaleOf(const SiteMap& site_map, const std::string& name) {
  if (name == "elevation") return ScaleOfHeights(site_map.map.elevation);
  if (name == "slope") return {0.0, kMaxSlopeDeg};
  if (name == "roughness") return {0.0, kMaxRoughnessM};
  if (name == "distance")
    return {0.0, std::max(1.0, DescribeLayer(site_map, name).max.value_or(1.0))};
  return {};
}

}  // namespace freelsd
