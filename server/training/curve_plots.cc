#include "server/training/curve_plots.h"

#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <sstream>

namespace freelsd {
namespace {

constexpr int kSidePx = 360;
constexpr int kMarginPx = 50;
constexpr std::array<const char*, 6> kColours{
    "#000000", "#1f77b4", "#d62728", "#2ca02c", "#9467bd", "#8c564b"};

// Counts of the regions whose probability of grass is at least a threshold.
struct Operation {
  double true_grass = 0.0;
  double false_grass = 0.0;
};

struct Curve {
  double num_grass = 0.0;
  double num_others = 0.0;
  // From the highest threshold to the lowest. Regions of equal probability share one threshold.
  std::vector<Operation> operations;
};

bool IsNamedGrass(const Answer& answer) {
  return answer.surface_class != kUnlabelledClass && answer.surface_class != kDormantGrassClass;
}

Curve CurveOf(const std::vector<Answer>& answers) {
  std::map<double, Operation, std::greater<>> by_probability;
  Curve curve;
  for (const Answer& answer : answers) {
    const bool is_grass = answer.surface_class == kGrassClass;
    Operation& here = by_probability[answer.label.probability];
    (is_grass ? here.true_grass : here.false_grass) += 1.0;
    (is_grass ? curve.num_grass : curve.num_others) += 1.0;
  }
  Operation sum;
  for (const auto& [probability, here] : by_probability) {
    sum.true_grass += here.true_grass;
    sum.false_grass += here.false_grass;
    curve.operations.push_back(sum);
  }
  return curve;
}

struct Point {
  double x = 0.0;
  double y = 0.0;
};

std::vector<Point> Roc(const Curve& curve) {
  std::vector<Point> points{{0.0, 0.0}};
  for (const Operation& operation : curve.operations) {
    points.push_back({operation.false_grass / std::max(1.0, curve.num_others),
                      operation.true_grass / std::max(1.0, curve.num_grass)});
  }
  return points;
}

std::vector<Point> PrecisionRecall(const Curve& curve) {
  std::vector<Point> points;
  for (const Operation& operation : curve.operations) {
    points.push_back({operation.true_grass / std::max(1.0, curve.num_grass),
                      operation.true_grass / (operation.true_grass + operation.false_grass)});
  }
  return points;
}

// Lower left corner of a plot; plots are numbered from the left.
Point Corner(int plot) {
  return {static_cast<double>(kMarginPx + plot * (kSidePx + 2 * kMarginPx)),
          static_cast<double>(kMarginPx + kSidePx)};
}

void DrawAxes(
    int plot, const char* title, const char* x_name, const char* y_name, std::ostream& svg) {
  const Point corner = Corner(plot);
  const double top = corner.y - kSidePx;
  svg << "<rect x='" << corner.x << "' y='" << top << "' width='" << kSidePx << "' height='"
      << kSidePx << "' fill='none' stroke='#888'/>\n"
      << "<text x='" << corner.x << "' y='" << top - 12 << "'>" << title << "</text>\n"
      << "<text x='" << corner.x << "' y='" << corner.y + 18 << "'>0 &#8594; 1: " << x_name
      << "</text>\n<text transform='translate(" << corner.x - 8 << " " << corner.y
      << ") rotate(-90)'>0 &#8594; 1: " << y_name << "</text>\n";
}

void DrawLine(int plot, const std::vector<Point>& points, const char* colour, std::ostream& svg) {
  const Point corner = Corner(plot);
  svg << "<polyline fill='none' stroke-width='1.5' stroke='" << colour << "' points='";
  for (const Point& point : points) {
    svg << corner.x + kSidePx * point.x << "," << corner.y - kSidePx * point.y << " ";
  }
  svg << "'/>\n";
}

}  // namespace

std::string CurvePlots(const std::vector<Answer>& answers) {
  std::map<std::string, std::vector<Answer>> groups;
  for (const Answer& answer : answers) {
    if (!IsNamedGrass(answer)) continue;
    groups[" all"].push_back(answer);
    groups[answer.place].push_back(answer);
  }
  std::ostringstream svg;
  svg << "<svg xmlns='http://www.w3.org/2000/svg' width='" << 2 * kSidePx + 4 * kMarginPx
      << "' height='" << kSidePx + 2 * kMarginPx << "' font-family='sans-serif' font-size='13'>\n"
      << "<rect width='100%' height='100%' fill='white'/>\n";
  DrawAxes(0, "ROC", "other surfaces called grass", "grass called grass", svg);
  DrawAxes(1, "Precision and recall", "recall", "precision", svg);
  size_t index = 0;
  for (const auto& [place, some] : groups) {
    const char* colour = kColours[index % kColours.size()];
    const Curve curve = CurveOf(some);
    DrawLine(0, Roc(curve), colour, svg);
    DrawLine(1, PrecisionRecall(curve), colour, svg);
    svg << "<text x='" << kMarginPx + kSidePx - 130 << "' y='"
        << kMarginPx + kSidePx / 2 + 18 * static_cast<int>(++index) << "' fill='" << colour << "'>"
        << place << " (" << some.size() << ")</text>\n";
  }
  svg << "</svg>\n";
  return svg.str();
}

}  // namespace freelsd
