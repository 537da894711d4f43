#include "api/export/report/drawing.h"

#include <cmath>

#include "api/export/text.h"

namespace freelsd {
namespace {

std::string Base64(const std::string& bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve(bytes.size() / 3 * 4 + 4);
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t group = 0;
    for (size_t j = 0; j < 3; ++j) {
      group = group << 8 | (i + j < bytes.size() ? static_cast<uint8_t>(bytes[i + j]) : 0u);
    }
    for (size_t j = 0; j < 4; ++j) {
      text += i + j > bytes.size() ? '=' : kDigits[group >> (18 - 6 * j) & 63];
    }
  }
  return text;
}

// North is up: y grows downwards in SVG.
std::string Points(const Polygon& line) {
  std::string points;
  for (const Eigen::Vector2d& point : line) {
    points += SvgNumber(point.x()) + "," + SvgNumber(-point.y()) + " ";
  }
  return points;
}

// Twice: a white line below makes the line visible on every ground.
std::string Line(const Polygon& line, const char* css_class) {
  if (line.empty()) return "";
  const std::string points = "\" points=\"" + Points(line) + "\"/>";
  return "<polyline class=\"casing" + points + "<polyline class=\"" + css_class + points;
}

void Extend(Eigen::AlignedBox2d& box, const Polygon& line) {
  for (const Eigen::Vector2d& point : line) box.extend(point);
}

}  // namespace

Eigen::AlignedBox2d SiteLines::LandingBox() const {
  Eigen::AlignedBox2d box(touchdown);
  Extend(box, final_line);
  Extend(box, ground_roll);
  return box;
}

Eigen::AlignedBox2d SiteLines::WholeBox() const {
  Eigen::AlignedBox2d box = LandingBox();
  Extend(box, circle);
  return box;
}

SiteLines LinesOf(const StoredSite& site, const LocalFrame& local_frame) {
  const auto place = [&local_frame](const GeoPoint& point) -> Eigen::Vector2d {
    return local_frame.WorldFromGeo(point).head<2>();
  };
  SiteLines lines;
  lines.touchdown = place(site.touchdown);
  for (const GeoPoint& corner : site.ground_roll) lines.ground_roll.push_back(place(corner));
  if (!lines.ground_roll.empty()) lines.ground_roll.push_back(lines.ground_roll.front());
  if (!site.final_places) return lines;
  lines.final_line = {place(site.final_places->start), lines.touchdown};
  for (const GeoPoint& point : site.final_places->circle) lines.circle.push_back(place(point));
  return lines;
}

Eigen::AlignedBox2d Grown(const Eigen::AlignedBox2d& box, double margin_m) {
  const Eigen::Vector2d margin = Eigen::Vector2d::Constant(margin_m);
  return {box.min() - margin, box.max() + margin};
}

std::string DataUri(const std::string& media_type, const std::string& bytes) {
  return "data:" + media_type + ";base64," + Base64(bytes);
}

std::string SvgNumber(double number) { return FixedText(number, 2); }

std::string Svg(const std::string& label,
                const Eigen::AlignedBox2d& box,
                const std::string& content) {
  return "<svg role=\"img\" aria-label=\"" + EscapeXml(label) + "\" viewBox=\"" +
         SvgNumber(box.min().x()) + " " + SvgNumber(-box.max().y()) + " " +
         SvgNumber(box.sizes().x()) + " " + SvgNumber(box.sizes().y()) + "\">" + content + "</svg>";
}

std::string ImageIn(const Eigen::AlignedBox2d& box,
                    const std::string& media_type,
                    const std::string& bytes) {
  if (bytes.empty()) return "";
  // A photograph is smoothed when it is enlarged, a layer keeps its cells.
  const std::string css_class = media_type == "image/jpeg" ? "class=\"photo\" " : "";
  return "<image " + css_class + "preserveAspectRatio=\"none\" x=\"" + SvgNumber(box.min().x()) +
         "\" y=\"" + SvgNumber(-box.max().y()) + "\" width=\"" + SvgNumber(box.sizes().x()) +
         "\" height=\"" + SvgNumber(box.sizes().y()) + "\" href=\"" + DataUri(media_type, bytes) +
         "\"/>";
}

std::string PathOf(const SiteLines& lines) {
  return Line(lines.ground_roll, "strip") + Line(lines.circle, "circle") +
         Line(lines.final_line, "final");
}

std::string TouchdownDot(const Eigen::Vector2d& place,
                         const Eigen::AlignedBox2d& box,
                         double share) {
  const double radius = 0.3 * share * box.sizes().maxCoeff();
  return "<circle class=\"touchdown\" cx=\"" + SvgNumber(place.x()) + "\" cy=\"" +
         SvgNumber(-place.y()) + "\" r=\"" + SvgNumber(radius) + "\"/>";
}

// A bar of 10, 20, 50, 100, ... metres, about a fifth of the width, in the lower left corner.
std::string ScaleAndNorth(const Eigen::AlignedBox2d& box, double share) {
  const double width = box.sizes().x();
  const double size = share * box.sizes().maxCoeff();
  const double power = std::pow(10.0, std::floor(std::log10(width / 5.0)));
  const double factor = width / 5.0 / power;
  const double bar = power * (factor >= 5.0 ? 5.0 : factor >= 2.0 ? 2.0 : 1.0);
  const double x = box.min().x() + size, y = -box.min().y() - size;
  const std::string font = " class=\"label\" font-size=\"" + SvgNumber(size) + "\">";
  const std::string line =
      "\" d=\"M" + SvgNumber(x) + " " + SvgNumber(y) + "h" + SvgNumber(bar) + "\"/>";
  return "<path class=\"casing" + line + "<path class=\"scale" + line + "<text x=\"" +
         SvgNumber(x) + "\" y=\"" + SvgNumber(y - 0.5 * size) + "\"" + font + FixedText(bar, 0) +
         " m</text><text x=\"" + SvgNumber(x) + "\" y=\"" + SvgNumber(-box.max().y() + 1.5 * size) +
         "\"" + font + "N &#8593;</text>";
}

}  // namespace freelsd
