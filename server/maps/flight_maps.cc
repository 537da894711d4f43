#include <algorithm>
#include <cmath>

#include <spdlog/spdlog.h>

#include "server/maps/maps.h"

namespace freelsd {
namespace {

// Eight rasters of float and two of bytes; an unseen tile needs its key only.
constexpr size_t kBytesPerTile = size_t{kTileCells} * kTileCells * 34;
constexpr size_t kBytesPerUnseenTile = 256;

TileKey KeyOf(const MapTileIndex& index) { return {index.level, index.row, index.col}; }

std::string TextOf(const std::string& map_id, const MapTileIndex& index) {
  return "tile " + std::to_string(index.level) + "/" + std::to_string(index.row) + "/" +
         std::to_string(index.col) + " of map " + map_id;
}

std::shared_ptr<const MapRasters> Decoded(const std::optional<std::string>& bytes,
                                          const Grid& grid,
                                          TileLayers layers) {
  if (!bytes) return nullptr;
  return std::make_shared<const MapRasters>(DeserializeTile(*bytes, grid, layers));
}

// Unknown where neither copy can be read.
std::shared_ptr<const MapRasters> ReadTile(const Storage& storage,
                                           const std::string& map_id,
                                           const MapTileIndex& index,
                                           const Grid& grid,
                                           TileLayers layers) {
  try {
    return Decoded(storage.maps.ReadTile(map_id, KeyOf(index)), grid, layers);
  } catch (const StorageError&) {
    throw;
  } catch (const DamagedMap& error) {
    // From now on storage reads from the second copy.
    spdlog::error("{}: {}", TextOf(map_id, index), error.what());
    storage.MarkDamaged(TextOf(map_id, index) + ": " + error.what());
  } catch (const std::exception& error) {
    spdlog::error("{} cannot be used: {}", TextOf(map_id, index), error.what());
    return nullptr;
  }
  try {
    return Decoded(storage.maps.ReadTileCopy(map_id, KeyOf(index)), grid, layers);
  } catch (const std::exception& error) {
    spdlog::error(
        "{}, second copy: {}; its ground counts as unseen", TextOf(map_id, index), error.what());
    return nullptr;
  }
}

bool Holds(TileLayers kept, TileLayers wanted) { return kept >= wanted; }

}  // namespace

Grid FlightMap::GridAt(int level) const {
  const Grid& finest = head.grid;
  const double size = std::ldexp(finest.cell_size_m, level);
  const Eigen::Vector2d extent =
      finest.cell_size_m * Eigen::Vector2d(finest.num_cols, -finest.num_rows);
  const Eigen::Vector2d corner = finest.north_west_in_world + extent;
  return GridAround({finest.north_west_in_world.x(), corner.y()},
                    {corner.x(), finest.north_west_in_world.y()},
                    size);
}

std::shared_ptr<const FlightMap> FlightMaps::Find(const Storage& storage,
                                                  const std::string& map_id) {
  {
    const std::lock_guard lock(mutex_);
    if (const auto found = heads_.find(map_id); found != heads_.end()) return found->second;
  }
  std::optional<FlightMapRow> row = storage.maps.Find(map_id);
  if (!row) return nullptr;
  std::shared_ptr<const FlightMap> made;
  try {
    MapHead head = ParseMapHead(row->head_json);
    const LocalFrame local_frame(head.origin);
    FlightRequest request = ParseStoredFlightRequest(head.flight_json);
    made = std::make_shared<const FlightMap>(FlightMap{*std::move(row),
                                                       std::move(head),
                                                       local_frame,
                                                       request.options.hazard,
                                                       std::move(request.aircraft),
                                                       std::move(request.memory)});
  } catch (const std::exception& error) {
    spdlog::error("map {} cannot be used: {}", map_id, error.what());
    return nullptr;
  }
  const std::lock_guard lock(mutex_);
  if (heads_.size() >= kMaxNumHeads) heads_.clear();
  return heads_.emplace(map_id, std::move(made)).first->second;
}

MapRasters FlightMaps::Read(
    const Storage& storage, const FlightMap& map, int level, const Grid& grid, TileLayers layers) {
  MapRasters rasters = UnseenRasters(grid);
  ElevationMap& elevation_map = rasters.site_map.map;
  elevation_map.position_sd_m = map.head.position_sd_m;
  elevation_map.tilt_sd_deg = map.head.tilt_sd_deg;
  elevation_map.is_compared = map.head.is_compared;
  HazardLayers& hazards = rasters.site_map.layers;
  hazards.min_grass_posterior = map.hazard_options.cover.min_grass_posterior;
  hazards.min_clear_class_posterior =
      map.hazard_options.cover.clear_class.min_clear_class_posterior;
  hazards.max_object_height_m =
      map.aircraft.max_roughness_m + map.hazard_options.cover.upper_margin_m;
  if (grid.num_rows == 0 || grid.num_cols == 0) return rasters;
  const auto [first, last] = TilesUnder(grid, 0);
  for (int row = first.row; row <= last.row; ++row) {
    for (int col = first.col; col <= last.col; ++col) {
      const auto tile = TileAt(storage, map, {level, row, col}, layers);
      if (tile) CopyCells(*tile, rasters);
    }
  }
  return rasters;
}

std::shared_ptr<const MapRasters> FlightMaps::TileAt(const Storage& storage,
                                                     const FlightMap& map,
                                                     const MapTileIndex& index,
                                                     TileLayers layers) {
  const Key key{map.row.id, index};
  {
    const std::lock_guard lock(mutex_);
    const Entry* const found = tiles_.Find(key);
    if (found != nullptr && Holds(found->layers, layers)) return found->tile;
  }
  auto tile =
      ReadTile(storage, map.row.id, index, GridOf(index, map.head.grid.cell_size_m), layers);
  const std::lock_guard lock(mutex_);
  tiles_.Keep(key, {layers, tile}, tile ? kBytesPerTile : kBytesPerUnseenTile);
  return tile;
}

std::shared_ptr<const std::string> MapPictures::Find(const std::string& key) {
  const std::lock_guard lock(mutex_);
  const auto* const found = pictures_.Find(key);
  return found != nullptr ? *found : nullptr;
}

void MapPictures::Keep(const std::string& key, const std::shared_ptr<const std::string>& picture) {
  const std::lock_guard lock(mutex_);
  pictures_.Keep(key, picture, key.size() + picture->size());
}

}  // namespace freelsd
