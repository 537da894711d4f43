#include <cmath>
#include <cstdio>
#include <stdexcept>

#include <opencv2/imgproc.hpp>

#include "api/export/layers/color_ramp.h"
#include "api/export/layers/layer_values.h"
#include "api/export/layers/png.h"

namespace freelsd {
namespace {

constexpr uint8_t kOpaque = 255;

// OpenCV's order of channels.
cv::Vec4b Bgra(const Color& color) { return {color[2], color[1], color[0], kOpaque}; }

// A picture needs at least one pixel. An empty map gives one transparent pixel.
cv::Mat4b Canvas(const SiteMap& site_map) {
  const cv::Size size = site_map.map.elevation.size();
  return cv::Mat4b(std::max(1, size.height), std::max(1, size.width), cv::Vec4b(0, 0, 0, 0));
}

// Drawn values: those of the layer, but for grass the posterior instead of its two classes.
cv::Mat1f DrawnValues(const SiteMap& site_map, const std::string& name) {
  return name == "grass" ? site_map.layers.grass : LayerValues(site_map, name);
}

// Brightness 0..1 of a cell lit from the north-west, 45 degrees above the horizon; flat: 0.7.
double Hillshade(const cv::Mat1f& elevation, int row, int col, double cell_size_m) {
  const auto height_at = [&](int r, int c) {
    const bool is_inside = r >= 0 && c >= 0 && r < elevation.rows && c < elevation.cols;
    const float height = is_inside ? elevation(r, c) : std::nanf("");
    return std::isfinite(height) ? height : elevation(row, col);
  };
  const double east = (height_at(row, col + 1) - height_at(row, col - 1)) / (2.0 * cell_size_m);
  const double north = (height_at(row - 1, col) - height_at(row + 1, col)) / (2.0 * cell_size_m);
  const Eigen::Vector3d normal = Eigen::Vector3d(-east, -north, 1.0).normalized();
  const Eigen::Vector3d light = Eigen::Vector3d(-1.0, 1.0, std::sqrt(2.0)).normalized();
  return std::max(0.0, normal.dot(light));
}

Color Shade(const Color& color, double brightness) {
  // Flat ground keeps its colour.
  constexpr double kFlatBrightness = 0.7071;
  const double factor = 0.4 + 0.6 * brightness / kFlatBrightness;
  Color shaded;
  for (int i = 0; i < 3; ++i) shaded[i] = cv::saturate_cast<uint8_t>(color[i] * factor);
  return shaded;
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

// --- Legend ---

constexpr int kLegendWidth = 280;
constexpr int kMargin = 12;
constexpr int kBarWidth = kLegendWidth - 2 * kMargin;
constexpr int kLineHeight = 18;
constexpr double kFontScale = 0.42;

void Write(cv::Mat3b& legend, const std::string& text, const cv::Point& baseline) {
  cv::putText(legend,
              text,
              baseline,
              cv::FONT_HERSHEY_SIMPLEX,
              kFontScale,
              cv::Scalar(30, 30, 30),
              1,
              cv::LINE_AA);
}

std::string Number(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.1f", value);
  return text;
}

std::string Title(const std::string& name) {
  if (name == "elevation") return "elevation, m";
  if (name == "slope") return "slope, deg";
  if (name == "roughness") return "roughness (ruggedness index), m";
  if (name == "grass") return "probability of grass";
  if (name == "distance") return "distance to hazard, m";
  return "hazard";
}

void DrawBar(cv::Mat3b& legend, const std::string& name, const Scale& scale, double offset) {
  const int top = kMargin + kLineHeight;
  for (int x = 0; x < kBarWidth; ++x) {
    const Color color = RampColor(name, x / (kBarWidth - 1.0));
    legend(cv::Rect(kMargin + x, top, 1, kLineHeight))
        .setTo(cv::Scalar(color[2], color[1], color[0]));
  }
  constexpr int kNumLabels = 3;
  for (int i = 0; i < kNumLabels; ++i) {
    const double share = i / (kNumLabels - 1.0);
    const std::string text = Number(offset + scale.min + share * (scale.max - scale.min));
    const int width = cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, kFontScale, 1, nullptr).width;
    const int x = kMargin + static_cast<int>(share * (kBarWidth - width));
    Write(legend, text, {x, top + 2 * kLineHeight - 3});
  }
}

void DrawSwatch(cv::Mat3b& legend, const Color& color, const std::string& text, int x, int y) {
  legend(cv::Rect(x, y, kLineHeight, kLineHeight - 4))
      .setTo(cv::Scalar(color[2], color[1], color[0]));
  Write(legend, text, {x + kLineHeight + 5, y + kLineHeight - 6});
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
  const bool has_bar = name != "hazard", has_swatches = name == "hazard" || name == "distance";
  const int num_lines = 1 + (has_bar ? 2 : 0) + (has_swatches ? 1 : 0);
  cv::Mat3b legend(2 * kMargin + num_lines * kLineHeight, kLegendWidth, cv::Vec3b(255, 255, 255));
  Write(legend, Title(name), {kMargin, kMargin + kLineHeight - 7});
  const double offset = name == "elevation" ? altitude_of_world_m : 0.0;
  if (has_bar) DrawBar(legend, name, ScaleOf(site_map, name), offset);
  if (has_swatches) {
    const int y = kMargin + (num_lines - 1) * kLineHeight + 4;
    constexpr int kStep = 84;
    DrawSwatch(legend, kHazardColor, "hazard", kMargin, y);
    DrawSwatch(legend, kUnseenColor, "unseen", kMargin + kStep, y);
    if (name == "hazard") DrawSwatch(legend, kFreeColor, "free", kMargin + 2 * kStep, y);
  }
  return EncodePng(legend);
}

}  // namespace freelsd
