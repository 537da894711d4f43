#include <cmath>
#include <limits>
#include <optional>

#include "api/export/map/map.h"
#include "engine/risk/risk.h"

namespace freelsd {
namespace {

// Upper heights without the height that the slope explains: a coarse cell has the highest point of
// its cells, and their mean elevation.
cv::Mat1f LevelUpper(const SiteMap& site_map, double finest_cell_size_m) {
  const auto& [map, layers] = site_map;
  const double extent = map.grid.cell_size_m - finest_cell_size_m;
  cv::Mat1f upper = map.upper.clone();
  for (int row = 0; row < upper.rows; ++row) {
    for (int col = 0; col < upper.cols; ++col) {
      const double rise = std::sqrt(0.5) * extent * std::tan(layers.slope(row, col));
      const double level = std::max<double>(map.elevation(row, col), upper(row, col) - rise);
      upper(row, col) = static_cast<float>(level);
    }
  }
  return upper;
}

}  // namespace

void AddRisk(MapWindow& window, const Aircraft& aircraft, double finest_cell_size_m) {
  const HazardLayers& layers = window.site_map.layers;
  ElevationMap map = window.site_map.map;
  if (map.grid.cell_size_m > finest_cell_size_m) {
    map.upper = LevelUpper(window.site_map, finest_cell_size_m);
  }
  window.risk = cv::Mat1f(map.elevation.size(), std::numeric_limits<float>::quiet_NaN());
  for (int row = 0; row < window.risk.rows; ++row) {
    for (int col = 0; col < window.risk.cols; ++col) {
      const std::optional<CellRisk> risk = RiskOfCell(map, layers, aircraft, {col, row});
      if (!risk) continue;
      window.risk(row, col) = static_cast<float>(1.0 - (1.0 - risk->kind) * (1.0 - risk->shape));
    }
  }
}

}  // namespace freelsd
