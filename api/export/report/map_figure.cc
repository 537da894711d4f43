#include "api/export/layers/layers.h"
#include "api/export/report/drawing.h"
#include "api/export/report/figures.h"

namespace freelsd {
namespace {

constexpr double kMarginM = 15.0;

Eigen::AlignedBox2d BoxOf(const Grid& grid) {
  Eigen::AlignedBox2d box;
  if (grid.num_rows == 0 || grid.num_cols == 0) return box;
  for (const Eigen::Vector2d& corner : OuterCorners(grid)) box.extend(corner);
  return box;
}

std::string Legend(const SiteMap& site_map, const LocalFrame& frame, const std::string& layer) {
  if (site_map.map.grid.num_rows == 0) return "";
  const std::string png = LegendPng(site_map, layer, frame.origin().altitude_m);
  return "<img alt=\"legend of " + layer + "\" src=\"" + DataUri("image/png", png) + "\"/>";
}

}  // namespace

std::string MapFigure(const StoredSite& site,
                      const SiteMap& site_map,
                      const LocalFrame& local_frame,
                      const std::string& layer) {
  const SiteLines lines = LinesOf(site, local_frame);
  const Eigen::AlignedBox2d map_box = BoxOf(site_map.map.grid);
  const Eigen::AlignedBox2d box = Grown(lines.WholeBox().merged(map_box), kMarginM);
  const std::string picture =
      map_box.isEmpty() ? "" : ImageIn(map_box, "image/png", LayerPng(site_map, layer));
  return "<figure>" +
         Svg("map of " + layer,
             box,
             picture + PathOf(lines) + TouchdownDot(lines.touchdown, box) + ScaleAndNorth(box)) +
         "<figcaption>" + layer + Legend(site_map, local_frame, layer) + "</figcaption></figure>\n";
}

}  // namespace freelsd
