#include <stdexcept>

#include "api/export/layers/layers.h"
#include "api/export/text.h"
#include "api/export/utm.h"

namespace freelsd {

std::string LayerWorldFile(const SiteMap& site_map, const LocalFrame& local_frame) {
  const Grid& grid = site_map.map.grid;
  if (grid.num_rows == 0 || grid.num_cols == 0) {
    throw std::invalid_argument("world file: the map is empty");
  }
  const auto m = UtmFromPixel(grid, ZoneOf(local_frame.origin()), local_frame);
  // Centre of the north-western pixel.
  const Eigen::Vector2d center = m * Eigen::Vector3d(0.5, 0.5, 1.0);
  std::string text;
  for (const double scale : {m(0, 0), m(1, 0), m(0, 1), m(1, 1)}) {
    text += FixedText(scale, 12) + "\n";
  }
  return text + FixedText(center.x(), 6) + "\n" + FixedText(center.y(), 6) + "\n";
}

}  // namespace freelsd
