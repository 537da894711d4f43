#include <utility>

#include "api/export/map/map.h"
#include "api/import/import.h"
#include "server/maps/maps.h"

namespace freelsd {
namespace {

bool FitsOneTile(const Grid& grid) {
  return grid.num_rows <= kTileCells && grid.num_cols <= kTileCells;
}

Tiles TilesOf(const MapRasters& rasters, int level, double cell_size_m) {
  const auto [first, last] = TilesUnder(rasters.site_map.map.grid, 0);
  Tiles tiles;
  for (int row = first.row; row <= last.row; ++row) {
    for (int col = first.col; col <= last.col; ++col) {
      MapRasters tile = UnseenRasters(GridOf({level, row, col}, cell_size_m));
      CopyCells(rasters, tile);
      std::string bytes = SerializeTile(tile);
      if (!bytes.empty()) tiles.push_back({{level, row, col}, bytes});
    }
  }
  return tiles;
}

std::vector<LayerRange> RangesOf(const MapRasters& rasters, const LocalFrame& local_frame) {
  std::vector<LayerRange> ranges;
  for (const std::string& layer : MapLayerNames()) {
    if (layer == "photo") continue;
    if (const auto scale = MapScale(layer, rasters, local_frame)) {
      ranges.push_back({layer, scale->min, scale->max});
    }
  }
  return ranges;
}

}  // namespace

std::string StageMap(Storage& storage, FlightMapRow row, MapHead head, MapRasters rasters) {
  head.num_levels = 1;
  for (Grid grid = head.grid; !FitsOneTile(grid); ++head.num_levels) {
    grid.num_rows = (grid.num_rows + 1) / 2 + 1;
    grid.num_cols = (grid.num_cols + 1) / 2 + 1;
  }
  head.ranges = RangesOf(rasters, LocalFrame(head.origin));
  row.head_json = MapHeadJson(head);
  storage.maps.Stage(row, {}, {});
  std::string digests;
  for (int level = 0; level < head.num_levels; ++level) {
    if (level > 0) rasters = Coarser(rasters);
    const Tiles tiles = TilesOf(rasters, level, head.grid.cell_size_m);
    for (const auto& [key, bytes] : tiles) digests += Sha256Hex(bytes);
    storage.maps.StageTiles(row.id, tiles, {});
  }
  return Sha256Hex(digests);
}

}  // namespace freelsd
