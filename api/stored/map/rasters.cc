#include <algorithm>
#include <cmath>
#include <limits>

#include "api/stored/map/map.h"

namespace freelsd {
namespace {

int FloorDiv(int value, int divisor) {
  return value >= 0 ? value / divisor : -((-value + divisor - 1) / divisor);
}

// Column (x) and row (y) of the grid's north-western cell on the lattice of its level.
cv::Point CornerOn(const Grid& grid) {
  return {static_cast<int>(std::lround(grid.north_west_in_world.x() / grid.cell_size_m)),
          static_cast<int>(std::lround(-grid.north_west_in_world.y() / grid.cell_size_m))};
}

cv::Rect CellsOf(const Grid& grid) {
  return {CornerOn(grid), cv::Size(grid.num_cols, grid.num_rows)};
}

template <typename Raster>
void Copy(const Raster& from, const cv::Rect& from_cells, Raster& to, const cv::Rect& to_cells) {
  if (!from.empty() && !to.empty()) from(from_cells).copyTo(to(to_cells));
}

}  // namespace

Grid GridOf(const MapTileIndex& index, double cell_size_m) {
  Grid grid;
  grid.cell_size_m = std::ldexp(cell_size_m, index.level);
  grid.north_west_in_world = kTileCells * grid.cell_size_m * Eigen::Vector2d(index.col, -index.row);
  grid.num_rows = grid.num_cols = kTileCells;
  return grid;
}

Grid PhotoLattice::GridOf(const MapTileIndex& index) const {
  Grid grid;
  grid.cell_size_m = std::ldexp(pixel_size_m, index.level);
  grid.north_west_in_world =
      tile_size_px * grid.cell_size_m * Eigen::Vector2d(index.col, -index.row);
  grid.num_rows = grid.num_cols = tile_size_px;
  return grid;
}

std::pair<MapTileIndex, MapTileIndex> TilesUnder(const Grid& grid, int level) {
  const cv::Rect cells = CellsOf(grid);
  const int side = kTileCells << level;
  return {{level, FloorDiv(cells.y, side), FloorDiv(cells.x, side)},
          {level,
           FloorDiv(cells.y + cells.height - 1, side),
           FloorDiv(cells.x + cells.width - 1, side)}};
}

namespace {

// Of the cue of that name; all unknown if it is new.
cv::Mat_<int8_t>& CueStepsIn(const std::string& cue, MapRasters& rasters) {
  for (CueLayer& known : rasters.cues) {
    if (known.name == cue) return known.steps;
  }
  const Grid& grid = rasters.site_map.map.grid;
  rasters.cues.push_back(
      {cue, cv::Mat_<int8_t>(grid.num_rows, grid.num_cols, int8_t{CueSteps::kUnknown})});
  return rasters.cues.back().steps;
}

}  // namespace

MapRasters UnseenRasters(const Grid& grid) {
  const cv::Size size(grid.num_cols, grid.num_rows);
  // A fill of its own: OpenCV's is slow, and recall makes many of these.
  const auto unknown = [&size] {
    cv::Mat1f raster(size);
    std::fill_n(raster.ptr<float>(), raster.total(), std::numeric_limits<float>::quiet_NaN());
    return raster;
  };
  MapRasters rasters;
  auto& [map, layers] = rasters.site_map;
  map.grid = layers.grid = grid;
  map.elevation = unknown();
  map.upper = unknown();
  map.standard_deviation = unknown();
  map.num_points = unknown();
  layers.slope = unknown();
  layers.roughness = unknown();
  layers.grass = unknown();
  layers.kind = cv::Mat1b::zeros(size);
  layers.hazard = cv::Mat1b(size, uchar{kUnseen});
  layers.distance = cv::Mat1f::zeros(size);
  rasters.coverage = cv::Mat1b::zeros(size);
  return rasters;
}

void CopyCells(const MapRasters& from, MapRasters& to) {
  const cv::Rect source = CellsOf(from.site_map.map.grid), target = CellsOf(to.site_map.map.grid);
  const cv::Rect common = source & target;
  if (common.empty()) return;
  const cv::Rect out = common - source.tl(), in = common - target.tl();
  const auto& [map, layers] = from.site_map;
  auto& [to_map, to_layers] = to.site_map;
  Copy(map.elevation, out, to_map.elevation, in);
  Copy(map.upper, out, to_map.upper, in);
  Copy(map.standard_deviation, out, to_map.standard_deviation, in);
  Copy(map.num_points, out, to_map.num_points, in);
  Copy(layers.slope, out, to_layers.slope, in);
  Copy(layers.roughness, out, to_layers.roughness, in);
  Copy(layers.grass, out, to_layers.grass, in);
  Copy(layers.kind, out, to_layers.kind, in);
  Copy(layers.hazard, out, to_layers.hazard, in);
  Copy(layers.distance, out, to_layers.distance, in);
  Copy(from.coverage, out, to.coverage, in);
  for (const CueLayer& cue : from.cues) {
    cv::Mat_<int8_t>& steps = CueStepsIn(cue.name, to);
    cue.steps(out).copyTo(steps(in));
  }
}

}  // namespace freelsd
