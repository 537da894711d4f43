#include "server/following/told_map.h"

#include <algorithm>
#include <array>

#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include "api/api.h"
#include "api/stored/map/map.h"

namespace freelsd {
namespace {

constexpr char kForm[] = "freelsd map 1\n";

Grid GridOfTile(const MapHead& head, const TileKey& key) {
  return GridOf({static_cast<int>(key.level), static_cast<int>(key.row), static_cast<int>(key.col)},
                head.grid.cell_size_m);
}

bool IsWhole(const std::string& tile, const MapHead& head, const TileKey& key) {
  try {
    DeserializeTile(tile, GridOfTile(head, key), TileLayers::kWithCues);
    return true;
  } catch (const std::exception&) {
    return false;
  }
}

std::string WholeTile(const Storage& storage,
                      const std::string& map_id,
                      const MapHead& head,
                      const TileKey& key) {
  const std::optional<std::string> tile = storage.maps.ReadTile(map_id, key);
  if (tile && IsWhole(*tile, head, key)) return *tile;
  const std::optional<std::string> copy = storage.maps.ReadTileCopy(map_id, key);
  if (copy && IsWhole(*copy, head, key)) return *copy;
  spdlog::error("a tile of map {} is damaged: it is not passed on", map_id);
  return {};
}

[[noreturn]] void RefuseBytes(const std::string& why) {
  throw ApiError("InvalidValue", "the bytes are no map: " + why, {{"", why}});
}

FlightMapRow ParseRow(const nlohmann::json& row) {
  FlightMapRow map;
  map.id = row.at("id");
  map.flight_id = row.at("flight_id");
  map.head_json = row.at("head");
  map.altitude_datum = row.at("altitude_datum");
  const std::array<double, 4> box = row.at("box");
  map.box = {box[0], box[1], box[2], box[3]};
  map.updated_at_us = row.at("updated_at_us");
  map.seen_at_us = row.at("seen_at_us");
  if (row.contains("seen_until_us")) map.seen_until_us = row.at("seen_until_us");
  return map;
}

TakenMap ParseWhole(const std::string& bytes) {
  const size_t begin = sizeof(kForm) - 1;
  const size_t line_end = bytes.find('\n', begin);
  if (!bytes.starts_with(kForm) || line_end == std::string::npos) RefuseBytes("another form");
  const nlohmann::json row = nlohmann::json::parse(bytes.substr(begin, line_end - begin));
  TakenMap taken{ParseRow(row), {}};
  const MapHead head = ParseMapHead(taken.map.head_json);
  size_t place = line_end + 1;
  for (const nlohmann::json& tile : row.at("tiles")) {
    const std::array<int64_t, 4> numbers = tile;
    const auto size = static_cast<size_t>(numbers[3]);
    if (numbers[3] < 0 || size > bytes.size() - place) RefuseBytes("a tile is cut off");
    const TileKey key{numbers[0], numbers[1], numbers[2]};
    taken.tiles.emplace_back(key, bytes.substr(place, size));
    if (!IsWhole(taken.tiles.back().second, head, key)) RefuseBytes("a tile is damaged");
    place += size;
  }
  if (place != bytes.size()) RefuseBytes("something follows the last tile");
  return taken;
}

}  // namespace

std::string MapBytes(const Storage& storage, const FlightMapRow& map) {
  const MapHead head = ParseMapHead(map.head_json);
  nlohmann::json row{
      {"id", map.id},
      {"flight_id", map.flight_id},
      {"head", map.head_json},
      {"altitude_datum", map.altitude_datum},
      {"box", {map.box.west_deg, map.box.south_deg, map.box.east_deg, map.box.north_deg}},
      {"updated_at_us", map.updated_at_us},
      {"seen_at_us", map.seen_at_us},
      {"tiles", nlohmann::json::array()}};
  if (map.seen_until_us) row["seen_until_us"] = *map.seen_until_us;
  std::string tiles;
  for (const TileKey& key : storage.maps.ListTiles(map.id)) {
    const std::string tile = WholeTile(storage, map.id, head, key);
    if (tile.empty()) continue;
    row["tiles"].push_back({key.level, key.row, key.col, tile.size()});
    tiles += tile;
  }
  return kForm + row.dump() + "\n" + tiles;
}

TakenMap ParseMapBytes(const std::string& bytes, const std::string& map_id) {
  try {
    TakenMap taken = ParseWhole(bytes);
    if (taken.map.id != map_id) RefuseBytes("its id is " + taken.map.id);
    if (!map_id.starts_with(taken.map.flight_id + "/")) RefuseBytes("its flight is another");
    return taken;
  } catch (const ApiError&) {
    throw;
  } catch (const std::exception& error) {
    RefuseBytes(error.what());
  }
}

}  // namespace freelsd
