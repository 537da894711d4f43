#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "api/export/report/figures.h"
#include "api/export/text.h"

namespace freelsd {
namespace {

// The middle is the calm. Around it, each speed has a ring; the lowest speed is the innermost one.
constexpr double kMiddleRadius = 20.0;
constexpr double kRimRadius = 124.0;
constexpr double kHalfSize = 146.0;

std::string Hundredths(double number) { return FixedText(number, 2); }

// North is up; the angle is where the wind comes from.
std::string Point(double radius, double from_deg) {
  const double from = RadFromDeg(from_deg);
  return Hundredths(radius * std::sin(from)) + " " + Hundredths(-radius * std::cos(from));
}

const char* VerdictWord(const Plan& plan) {
  if (plan.verdict == Verdict::kLandable) return "landable";
  return plan.verdict == Verdict::kUnverified ? "unverified" : "rejected";
}

bool HasCalm(const WindRose& rose) { return rose.speeds.front() <= 0.0; }

double RingWidth(const WindRose& rose) {
  const size_t num_rings = rose.speeds.size() - (HasCalm(rose) ? 1 : 0);
  return (kRimRadius - kMiddleRadius) / static_cast<double>(std::max<size_t>(1, num_rings));
}

double InnerRadius(const WindRose& rose, size_t speed) {
  const size_t ring = HasCalm(rose) ? speed - 1 : speed;
  return kMiddleRadius + static_cast<double>(ring) * RingWidth(rose);
}

std::string Calm(const WindRose& rose) {
  return "<circle class=\"cell " + std::string(VerdictWord(rose.At(0, 0))) + "\" r=\"" +
         Hundredths(kMiddleRadius) + "\"/>";
}

std::string Cell(const WindRose& rose, size_t speed, size_t direction) {
  const double width_deg = 360.0 / rose.num_directions;
  const double left = (static_cast<double>(direction) - 0.5) * width_deg, right = left + width_deg;
  const double inner = InnerRadius(rose, speed);
  const double outer = inner + RingWidth(rose);
  const auto arc = [](double radius, int sweep, double to) {
    return "A" + Hundredths(radius) + " " + Hundredths(radius) + " 0 0 " + std::to_string(sweep) +
           " " + Point(radius, to);
  };
  return "<path class=\"cell " + std::string(VerdictWord(rose.At(speed, direction))) + "\" d=\"M" +
         Point(inner, left) + "L" + Point(outer, left) + arc(outer, 1, right) + "L" +
         Point(inner, right) + arc(inner, 0, left) + "Z\"/>";
}

std::string Text(const std::string& position, const std::string& text) {
  const size_t space = position.find(' ');
  return "<text class=\"label\" font-size=\"13\" text-anchor=\"middle\" dy=\"4.5\" x=\"" +
         position.substr(0, space) + "\" y=\"" + position.substr(space + 1) + "\">" + text +
         "</text>";
}

// The speeds stand between two columns of cells.
std::string AxisLabels(const WindRose& rose) {
  constexpr const char* kNames[] = {"N", "E", "S", "W"};
  std::string labels;
  for (int i = 0; i < 4; ++i) labels += Text(Point(kRimRadius + 12.0, 90.0 * i), kNames[i]);
  const double between_deg = 45.0 + 180.0 / rose.num_directions;
  for (size_t i = HasCalm(rose) ? 1 : 0; i < rose.speeds.size(); ++i) {
    const double radius = InnerRadius(rose, i) + 0.5 * RingWidth(rose);
    labels += Text(Point(radius, between_deg), nlohmann::json(rose.speeds[i]).dump());
  }
  return labels;
}

std::string LegendItem(const std::string& verdict) {
  return "<li><svg aria-hidden=\"true\" viewBox=\"0 0 28 18\"><path class=\"cell " + verdict +
         "\" d=\"M1 1H27V17H1Z\"/></svg>" + verdict + "</li>\n";
}

std::string InWords(const WindRose& rose) {
  // A calm has no direction: its plans count once.
  const size_t first = HasCalm(rose) ? static_cast<size_t>(rose.num_directions) - 1 : 0;
  int num_landable = 0, num_unverified = 0;
  for (size_t i = first; i < rose.plans.size(); ++i) {
    num_landable += rose.plans[i].verdict == Verdict::kLandable;
    num_unverified += rose.plans[i].verdict == Verdict::kUnverified;
  }
  return "Of " + std::to_string(rose.plans.size() - first) + " winds, " +
         std::to_string(num_landable) + " allow a landing, " + std::to_string(num_unverified) +
         " an unverified one.";
}

}  // namespace

std::string RosePatterns() {
  return "<svg class=\"patterns\" aria-hidden=\"true\" width=\"0\" height=\"0\"><defs><pattern "
         "id=\"unverified\" width=\"6\" height=\"6\" patternUnits=\"userSpaceOnUse\" "
         "patternTransform=\"rotate(45)\"><rect width=\"6\" height=\"6\" fill=\"#fff\"/><rect "
         "width=\"3\" height=\"6\" fill=\"#e69f00\"/></pattern><pattern id=\"rejected\" "
         "width=\"8\" height=\"8\" patternUnits=\"userSpaceOnUse\"><rect width=\"8\" height=\"8\" "
         "fill=\"#fff\"/><path d=\"M2 2L6 6M6 2L2 6\" "
         "stroke=\"#d55e00\"/></pattern></defs></svg>\n";
}

std::string RoseFigure(const WindRose& rose) {
  if (rose.speeds.empty() || rose.num_directions < 1) return "";
  std::string cells = HasCalm(rose) ? Calm(rose) : "";
  for (size_t speed = HasCalm(rose) ? 1 : 0; speed < rose.speeds.size(); ++speed) {
    for (size_t i = 0; i < static_cast<size_t>(rose.num_directions); ++i) {
      cells += Cell(rose, speed, i);
    }
  }
  const std::string corner = Hundredths(-kHalfSize), side = Hundredths(2.0 * kHalfSize);
  return "<figure class=\"rose\"><svg role=\"img\" aria-label=\"winds in which one can land\" "
         "viewBox=\"" +
         corner + " " + corner + " " + side + " " + side + "\">" + cells + AxisLabels(rose) +
         "</svg><figcaption>Winds by where they come from; rings by speed in m/s, calm in the "
         "middle. " +
         InWords(rose) + "<ul class=\"legend\">\n" + LegendItem("landable") +
         LegendItem("unverified") + LegendItem("rejected") + "</ul></figcaption></figure>\n";
}

}  // namespace freelsd
