#include <cmath>

#include "api/export/color_ramp.h"
#include "api/export/hillshade.h"
#include "api/export/layers/layer_values.h"
#include "api/export/layers/scale.h"
#include "api/export/legend.h"
#include "api/export/png.h"

namespace freelsd {
namespace {

// A picture needs at least one pixel. An empty map gives one transparent pixel.
cv::Mat4b Canvas(const SiteMap& site_map) {
  const cv::Size size = site_map.map.elevation.size();
  return cv::Mat4b(std::max(1, size.height), std::max(1, size.width), cv::Vec4b(0, 0, 0, 0));
}

// Drawn values: those of the layer, but for grass the posterior instead of its two classes.
cv::Mat1f DrawnValues(const SiteMap& site_map, const std::string& name) {
  return name == "grass" ? site_map.layers.grass : LayerValues(site_map, name);
}

cv::Mat4b DrawRamp(const SiteMap& site_map, const std::string& name) {
  cv::Mat4b picture = Canvas(site_map);
  const cv::Mat1f values = DrawnValues(site_map, name);
  const Scale scale = ScaleOf(site_map, name);
  for (int row = 0; row < values.rows; ++row) {
    for (int col = 0; col < values.cols; ++col) {
      if (!std::isfinite(values(row, col))) continue;
      Color color = RampColor(name, (values(row, col) - scale.min) / (scale.max - scale.min));
      if (name == "elevation") {
        color = Shade(color, Hillshade(values, row, col, site_map.map.grid.cell_size_m));
      }
      picture(row, col) = Bgra(color);
    }
  }
  return picture;
}

// Hazard, or distance with the hazards in it. Every cell is opaque.
cv::Mat4b DrawSafety(const SiteMap& site_map, const std::string& name) {
  cv::Mat4b picture = name == "distance" ? DrawRamp(site_map, name) : Canvas(site_map);
  const cv::Mat1b& hazard = site_map.layers.hazard;
  for (int row = 0; row < hazard.rows; ++row) {
    for (int col = 0; col < hazard.cols; ++col) {
      if (hazard(row, col) == kHazard) {
        picture(row, col) = Bgra(kHazardColor);
      } else if (hazard(row, col) != kFree) {
        picture(row, col) = Bgra(kUnseenColor);
      } else if (name == "hazard") {
        picture(row, col) = Bgra(kFreeColor);
      }
    }
  }
  return picture;
}

}  // namespace

std::string LayerPng(const SiteMap& site_map, const std::string& name) {
  const bool is_safety = name == "hazard" || name == "distance";
  return EncodePng(is_safety ? DrawSafety(site_map, name) : DrawRamp(site_map, name));
}

std::string LegendPng(const SiteMap& site_map,
                      const std::string& name,
                      double altitude_of_world_m) {
  DescribeLayer(site_map, name);  // refuses names that are no layer
  const double offset = name == "elevation" ? altitude_of_world_m : 0.0;
  const Scale scale = ScaleOf(site_map, name);
  return LegendPng(name, {scale.min + offset, scale.max + offset});
}

}  // namespace freelsd
