#include "api/export/map/map_layer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace freelsd {
namespace {

constexpr float kNoValue = std::numeric_limits<float>::quiet_NaN();

struct LayerName {
  const char* name;
  MapLayer layer;
  const char* unit;
};

constexpr LayerName kLayers[] = {
    {"photo", MapLayer::kPhoto, ""},
    {"hazard", MapLayer::kHazard, "class"},
    {"elevation", MapLayer::kElevation, "m"},
    {"slope", MapLayer::kSlope, "deg"},
    {"roughness", MapLayer::kRoughness, "m"},
    {"grass", MapLayer::kGrass, "class"},
    {"distance", MapLayer::kDistance, "m"},
    {"height_sd", MapLayer::kHeightSd, "m"},
    {"coverage", MapLayer::kCoverage, "photographs"},
    {"risk", MapLayer::kRisk, "probability"},
    {"kind", MapLayer::kKind, "class"},
};

void CheckSize(const char* name, const cv::Mat& raster, const Grid& grid, bool may_be_empty) {
  if (may_be_empty && raster.empty()) return;
  if (raster.rows == grid.num_rows && raster.cols == grid.num_cols) return;
  throw std::invalid_argument("window." + std::string(name) + ": is " +
                              std::to_string(raster.cols) + " x " + std::to_string(raster.rows) +
                              " cells, the grid has " + std::to_string(grid.num_cols) + " x " +
                              std::to_string(grid.num_rows));
}

void CheckCellSize(const Grid& grid) {
  if (std::isfinite(grid.cell_size_m) && grid.cell_size_m > 0.0) return;
  throw std::invalid_argument("window.grid.cell_size_m = " + std::to_string(grid.cell_size_m) +
                              ": must be positive");
}

}  // namespace

MapLayer MapLayerOf(const std::string& name) {
  for (const LayerName& layer : kLayers) {
    if (name == layer.name) return layer.layer;
  }
  throw std::invalid_argument("layer = " + name + ": no such layer");
}

MapLayer ValueLayerOf(const std::string& name) {
  const MapLayer layer = MapLayerOf(name);
  if (layer == MapLayer::kPhoto) {
    throw std::invalid_argument("layer = photo: has no values, only a picture");
  }
  return layer;
}

std::string UnitOf(MapLayer layer) {
  return std::find_if(std::begin(kLayers),
                      std::end(kLayers),
                      [&](const LayerName& named) { return named.layer == layer; })
      ->unit;
}

std::vector<std::string> MapLayerNames() {
  std::vector<std::string> names;
  for (const LayerName& layer : kLayers) names.emplace_back(layer.name);
  return names;
}

void CheckWindow(const MapWindow& window) {
  const auto& [map, layers] = window.site_map;
  CheckCellSize(map.grid);
  CheckSize("elevation", map.elevation, map.grid, false);
  CheckSize("hazard", layers.hazard, map.grid, false);
  CheckSize("standard_deviation", map.standard_deviation, map.grid, true);
  CheckSize("slope", layers.slope, map.grid, true);
  CheckSize("roughness", layers.roughness, map.grid, true);
  CheckSize("grass", layers.grass, map.grid, true);
  CheckSize("kind", layers.kind, map.grid, true);
  CheckSize("distance", layers.distance, map.grid, true);
  CheckSize("coverage", window.coverage, map.grid, true);
  CheckSize("risk", window.risk, map.grid, true);
}

void CheckWindow(const PhotoWindow& window) {
  CheckCellSize(window.grid);
  CheckSize("pixels", window.pixels, window.grid, false);
}

bool LayerRaster::IsEmpty() const {
  return counts ? counts->empty() : kinds ? kinds->empty() : values->empty();
}

float LayerRaster::At(int row, int col) const {
  if (kinds) {
    const uint8_t kind = (*kinds)(row, col);
    return kind > 0 ? static_cast<float>(LikelyKind::Unpack(kind).kind) : kNoValue;
  }
  if (!counts) return (*values)(row, col) * factor;
  const uint8_t count = (*counts)(row, col);
  return count > 0 ? static_cast<float>(count) : kNoValue;
}

LayerRaster RasterOf(const MapWindow& window, MapLayer layer) {
  const auto& [map, layers] = window.site_map;
  if (layer == MapLayer::kElevation) return {.values = &map.elevation};
  if (layer == MapLayer::kHeightSd) return {.values = &map.standard_deviation};
  if (layer == MapLayer::kRoughness) return {.values = &layers.roughness};
  if (layer == MapLayer::kGrass) return {.values = &layers.grass};
  if (layer == MapLayer::kDistance) return {.values = &layers.distance};
  if (layer == MapLayer::kCoverage) return {.counts = &window.coverage};
  if (layer == MapLayer::kRisk) return {.values = &window.risk};
  if (layer == MapLayer::kKind) return {.kinds = &layers.kind};
  if (layer != MapLayer::kSlope) throw std::invalid_argument("layer: has no values");
  return {.values = &layers.slope, .factor = static_cast<float>(DegFromRad(1.0))};
}

CellFinder::CellFinder(const std::vector<MapWindow>& windows) {
  for (const MapWindow& window : windows) {
    CheckWindow(window);
    const Grid& grid = window.site_map.map.grid;
    windows_.push_back({&window,
                        grid.north_west_in_world.x(),
                        grid.north_west_in_world.y(),
                        1.0 / grid.cell_size_m,
                        grid.num_rows,
                        grid.num_cols});
  }
}

WindowCell CellFinder::At(const Eigen::Vector2d& place_in_world) const {
  constexpr int kSeen = 3;
  WindowCell best;
  int best_rank = -1;
  for (size_t i = 0; i < windows_.size(); ++i) {
    const Placed& placed = windows_[i];
    const double x = (place_in_world.x() - placed.west) * placed.cells_per_m;
    const double y = (placed.north - place_in_world.y()) * placed.cells_per_m;
    if (!(x >= 0.0 && y >= 0.0 && x < placed.num_cols && y < placed.num_rows)) continue;
    const int row = static_cast<int>(y), col = static_cast<int>(x);
    const auto& [map, layers] = placed.window->site_map;
    const cv::Mat1b& coverage = placed.window->coverage;
    const int rank = layers.hazard(row, col) != kUnseen            ? kSeen
                     : !std::isnan(map.elevation(row, col))        ? 2
                     : !coverage.empty() && coverage(row, col) > 0 ? 1
                                                                   : 0;
    if (rank <= best_rank) continue;
    best = {placed.window, static_cast<int>(i), row, col};
    best_rank = rank;
    if (rank == kSeen) break;
  }
  return best;
}

}  // namespace freelsd
