#include "api/export/legend.h"

#include <cstdio>

#include <opencv2/imgproc.hpp>

#include "api/export/color_ramp.h"
#include "api/export/png.h"
#include "engine/ground_kind/ground_kind.h"

namespace freelsd {
namespace {

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
  if (name == "height_sd") return "standard deviation of elevation, m";
  if (name == "coverage") return "photographs that see the cell";
  if (name == "risk") return "probability that the ground is unfit";
  if (name == "kind") return "likeliest kind of ground";
  return "hazard, with entered obstacles";
}

void DrawBar(cv::Mat3b& legend, const std::string& name, const Scale& scale) {
  const int top = kMargin + kLineHeight;
  for (int x = 0; x < kBarWidth; ++x) {
    const Color color = RampColor(name, x / (kBarWidth - 1.0));
    legend(cv::Rect(kMargin + x, top, 1, kLineHeight))
        .setTo(cv::Scalar(color[2], color[1], color[0]));
  }
  constexpr int kNumLabels = 3;
  for (int i = 0; i < kNumLabels; ++i) {
    const double share = i / (kNumLabels - 1.0);
    const std::string text = Number(scale.min + share * (scale.max - scale.min));
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

std::string KindLegendPng() {
  constexpr int kNumCols = 3, kStep = 84;
  constexpr int kNumLines = 1 + (kNumGroundKinds + kNumCols - 1) / kNumCols;
  cv::Mat3b legend(2 * kMargin + kNumLines * kLineHeight, kLegendWidth, cv::Vec3b(255, 255, 255));
  Write(legend, Title("kind"), {kMargin, kMargin + kLineHeight - 7});
  for (int kind = 0; kind < kNumGroundKinds; ++kind) {
    DrawSwatch(legend,
               RampColor("kind", (kind + 0.5) / kNumGroundKinds),
               NameOf(static_cast<GroundKind>(kind)),
               kMargin + kind % kNumCols * kStep,
               kMargin + (1 + kind / kNumCols) * kLineHeight + 4);
  }
  return EncodePng(legend);
}

}  // namespace

std::string LegendPng(const std::string& name, const Scale& scale) {
  if (name == "kind") return KindLegendPng();
  const bool has_bar = name != "hazard",
             has_swatches = name == "hazard" || name == "distance" || name == "risk";
  const int num_lines = 1 + (has_bar ? 2 : 0) + (has_swatches ? 1 : 0);
  cv::Mat3b legend(2 * kMargin + num_lines * kLineHeight, kLegendWidth, cv::Vec3b(255, 255, 255));
  Write(legend, Title(name), {kMargin, kMargin + kLineHeight - 7});
  if (has_bar) DrawBar(legend, name, scale);
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
