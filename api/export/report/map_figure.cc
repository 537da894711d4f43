#include <algorithm>
#include <cmath>

#include "api/export/layers/layers.h"
#include "api/export/report/figures.h"
#include "api/export/text.h"

namespace freelsd {
namespace {

constexpr double kMarginM = 15.0;

std::string Base64(const std::string& bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
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

std::string PictureUri(const std::string& png) { return "data:image/png;base64," + Base64(png); }

// East and north in metres.
struct Drawing {
  std::vector<Eigen::Vector2d> final_line;
  std::vector<Eigen::Vector2d> circle;
  Eigen::Vector2d touchdown;
  Eigen::AlignedBox2d box;
};

Drawing DrawingOf(const StoredSite& site, const SiteMap& site_map, const LocalFrame& frame) {
  const auto place = [&frame](const GeoPoint& point) -> Eigen::Vector2d {
    return frame.WorldFromGeo(point).head<2>();
  };
  Drawing drawing;
  drawing.touchdown = place(site.touchdown);
  drawing.box.extend(drawing.touchdown);
  if (site.final_places) {
    drawing.final_line = {place(site.final_places->start), drawing.touchdown};
    drawing.box.extend(drawing.final_line.front());
    for (const GeoPoint& point : site.final_places->circle) {
      drawing.circle.push_back(place(point));
      drawing.box.extend(drawing.circle.back());
    }
  }
  const Grid& grid = site_map.map.grid;
  if (grid.num_rows > 0 && grid.num_cols > 0) {
    for (const Eigen::Vector2d& corner : OuterCorners(grid)) drawing.box.extend(corner);
  }
  drawing.box.extend((drawing.box.min().array() - kMarginM).matrix().eval());
  drawing.box.extend((drawing.box.max().array() + kMarginM).matrix().eval());
  return drawing;
}

std::string Number(double number) { return FixedText(number, 2); }

// North is up: y grows downwards in SVG.
std::string Polyline(const std::vector<Eigen::Vector2d>& line, const char* css_class) {
  std::string points;
  for (const Eigen::Vector2d& point : line) {
    points += Number(point.x()) + "," + Number(-point.y()) + " ";
  }
  return "<polyline class=\"" + std::string(css_class) + "\" points=\"" + points + "\"/>";
}

std::string Image(const SiteMap& site_map, const std::string& layer) {
  const Grid& grid = site_map.map.grid;
  if (grid.num_rows == 0 || grid.num_cols == 0) return "";
  return "<image preserveAspectRatio=\"none\" x=\"" + Number(grid.north_west_in_world.x()) +
         "\" y=\"" + Number(-grid.north_west_in_world.y()) + "\" width=\"" +
         Number(grid.num_cols * grid.cell_size_m) + "\" height=\"" +
         Number(grid.num_rows * grid.cell_size_m) + "\" href=\"" +
         PictureUri(LayerPng(site_map, layer)) + "\"/>";
}

// A bar of 10, 20, 50, 100, ... metres, about a fifth of the width, in the lower left corner.
std::string ScaleAndNorth(const Eigen::AlignedBox2d& box) {
  const double width = box.sizes().x();
  const double size = 0.03 * box.sizes().maxCoeff();
  const double power = std::pow(10.0, std::floor(std::log10(width / 5.0)));
  const double share = width / 5.0 / power;
  const double bar = power * (share >= 5.0 ? 5.0 : share >= 2.0 ? 2.0 : 1.0);
  const double x = box.min().x() + size, y = -box.min().y() - size;
  const std::string font = " font-size=\"" + Number(size) + "\">";
  return "<path class=\"scale\" d=\"M" + Number(x) + " " + Number(y) + "h" + Number(bar) +
         "\"/><text x=\"" + Number(x) + "\" y=\"" + Number(y - 0.5 * size) + "\"" + font +
         FixedText(bar, 0) + " m</text><text x=\"" + Number(x) + "\" y=\"" +
         Number(-box.max().y() + 1.5 * size) + "\"" + font + "N &#8593;</text>";
}

std::string Legend(const SiteMap& site_map, const LocalFrame& frame, const std::string& layer) {
  if (site_map.map.grid.num_rows == 0) return "";
  return "<img alt=\"legend of " + layer + "\" src=\"" +
         PictureUri(LegendPng(site_map, layer, frame.origin().altitude_m)) + "\"/>";
}

}  // namespace

std::string MapFigure(const StoredSite& site,
                      const SiteMap& site_map,
                      const LocalFrame& local_frame,
                      const std::string& layer) {
  const Drawing drawing = DrawingOf(site, site_map, local_frame);
  const Eigen::AlignedBox2d& box = drawing.box;
  const double radius = 0.008 * box.sizes().maxCoeff();
  return "<figure><svg role=\"img\" aria-label=\"map of " + layer + "\" viewBox=\"" +
         Number(box.min().x()) + " " + Number(-box.max().y()) + " " + Number(box.sizes().x()) +
         " " + Number(box.sizes().y()) + "\">" + Image(site_map, layer) +
         Polyline(drawing.circle, "casing") + Polyline(drawing.circle, "circle") +
         Polyline(drawing.final_line, "casing") + Polyline(drawing.final_line, "final") +
         "<circle class=\"touchdown\" cx=\"" + Number(drawing.touchdown.x()) + "\" cy=\"" +
         Number(-drawing.touchdown.y()) + "\" r=\"" + Number(radius) + "\"/>" + ScaleAndNorth(box) +
         "</svg><figcaption>" + layer + Legend(site_map, local_frame, layer) +
         "</figcaption></figure>\n";
}

}  // namespace freelsd
