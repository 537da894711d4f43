#include "server/handlers/flight_picture.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include <nlohmann/json.hpp>

#include "api/api.h"
#include "api/import/import.h"
#include "server/http/http.h"

namespace freelsd {
namespace {

constexpr const char* kRisk = "risk";
// Of the digest of the obstacles.
constexpr size_t kNumKeyDigits = 16;

WorldBox Joined(const WorldBox& a, const WorldBox& b) {
  return {a.min_in_world.cwiseMin(b.min_in_world), a.max_in_world.cwiseMax(b.max_in_world)};
}

Polygon CornersOf(const WorldBox& box) { return {box.min_in_world, box.max_in_world}; }

double PixelSizeOf(const WorldBox& box, int longest_px) {
  return (box.max_in_world - box.min_in_world).maxCoeff() / longest_px;
}

// The coarsest level has few tiles.
bool HasPhotoTiles(const Storage& storage, const FlightMap& map) {
  return !storage.maps.ListPhotoTiles(map.row.id, map.head.photo->num_levels - 1).empty();
}

std::shared_ptr<const FlightMap> WithoutPicture(FlightMap map) {
  map.head.photo.reset();
  return std::make_shared<const FlightMap>(std::move(map));
}

}  // namespace

std::vector<std::shared_ptr<const FlightMap>> ReadableMaps(const Service& service,
                                                           const std::string& flight_id) {
  std::vector<std::shared_ptr<const FlightMap>> maps;
  for (const FlightMapRow& row : service.storage.maps.ListOf(flight_id)) {
    auto map = service.maps.flight_maps().Find(service.storage, row.id);
    if (!map) continue;
    const bool is_picture_gone = map->head.photo && !HasPhotoTiles(service.storage, *map);
    maps.push_back(is_picture_gone ? WithoutPicture(*map) : std::move(map));
  }
  return maps;
}

FlightPicture::FlightPicture(const Service& service,
                             const std::string& flight_id,
                             StopIfUnwanted stop_if_unwanted)
    : service_(service),
      flight_id_(flight_id),
      stop_if_unwanted_(std::move(stop_if_unwanted)),
      maps_(ReadableMaps(service, flight_id)) {
  if (maps_.empty()) {
    if (!service.storage.flights.Find(flight_id)) {
      throw ApiError("NoSuchFlight", "there is no such flight");
    }
    throw ApiError("NoMap", "the flight has no map yet");
  }
  const WorldBox extent = Extent();
  const Eigen::Vector2d middle = 0.5 * (extent.min_in_world + extent.max_in_world);
  const double reach_m = 0.5 * (extent.max_in_world - extent.min_in_world).norm();
  const KnownObstacles near = service.maps.ObstaclesNear(
      service.storage,
      BoxAroundPlace(Frame().GeoFromWorld({middle.x(), middle.y(), 0.0}), reach_m));
  // Pictures do not show how high an obstacle is, so the datum does not matter.
  obstacles_ = InWorld(near, Frame(), {"unknown", 0.0, 0.0, ""});
  for (const auto& map : maps_) updated_at_us_ = std::max(updated_at_us_, map->row.updated_at_us);
  for (const auto& known : near) updated_at_us_ = std::max(updated_at_us_, known->updated_at_us);
  const auto num_pictures = std::count_if(
      maps_.begin(), maps_.end(), [](const auto& map) { return map->head.photo.has_value(); });
  const std::string& newest = maps_.front()->row.id;
  version_ = newest.substr(newest.rfind('/') + 1) + "-" + std::to_string(maps_.size()) + "-" +
             std::to_string(num_pictures) + "-" + std::to_string(updated_at_us_);
  if (!near.empty()) version_ += "-" + Sha256Hex(KeyOf(near)).substr(0, kNumKeyDigits);
}

int FlightPicture::NumLevels() const {
  int num_levels = 1;
  for (const auto& map : maps_) num_levels = std::max(num_levels, map->head.num_levels);
  return num_levels;
}

WorldBox FlightPicture::Extent() const {
  WorldBox extent = BoxOfGrid(maps_.front()->head.grid);
  for (const auto& map : maps_) extent = Joined(extent, BoxOfGrid(map->head.grid));
  return extent;
}

std::optional<Scale> FlightPicture::ScaleOf(const std::string& layer) const {
  // Computed when it is drawn, so also for maps that are older than this layer.
  if (layer == kRisk) return RiskScale();
  std::optional<Scale> scale;
  for (const auto& map : maps_) {
    for (const LayerRange& range : map->head.ranges) {
      if (range.name != layer) continue;
      const Scale of_map{range.min, range.max};
      scale = scale ? MergedScale(*scale, of_map) : of_map;
    }
  }
  return scale;
}

Scale FlightPicture::NeededScale(const std::string& layer) const {
  if (const std::optional<Scale> scale = ScaleOf(layer)) return *scale;
  throw ApiError("NoMap", "the flight has no layer " + layer);
}

std::vector<MapWindow> FlightPicture::Windows(const std::string& layer,
                                              const WorldBox& box,
                                              int level) const {
  stop_if_unwanted_();
  std::vector<MapWindow> windows;
  for (const auto& map : maps_) {
    const int own_level = std::min(level, map->head.num_levels - 1);
    const Grid whole = map->GridAt(own_level);
    const Grid part = whole.Part(whole.CellsAround(CornersOf(box), 0.0));
    if (part.num_rows == 0 || part.num_cols == 0) continue;
    windows.push_back(service_.maps.flight_maps().Read(
        service_.storage, *map, own_level, part, TileLayers::kAll));
    HazardLayers& layers = windows.back().site_map.layers;
    layers = WithObstacleHazards(std::move(layers), obstacles_, {});
    if (layer == kRisk) AddRisk(windows.back(), map->aircraft, map->head.grid.cell_size_m);
  }
  return windows;
}

std::vector<MapWindow> FlightPicture::WindowsFor(const std::string& layer,
                                                 const WorldBox& box,
                                                 double pixel_size_m) const {
  const double cell_size_m = maps_.front()->head.grid.cell_size_m;
  int level = 0;
  while (level + 1 < NumLevels() && std::ldexp(cell_size_m, level + 1) <= pixel_size_m) ++level;
  return Windows(layer, box, level);
}

MapSource FlightPicture::Source(const std::string& layer) const {
  return {Extent(),
          maps_.front()->head.grid.cell_size_m,
          NumLevels(),
          [this, layer](const WorldBox& box, int level) { return Windows(layer, box, level); },
          {}};
}

std::optional<double> FlightPicture::PhotoPixelSize() const {
  std::optional<double> finest;
  for (const auto& map : maps_) {
    if (!map->head.photo) continue;
    const double pixel_size_m = map->head.photo->pixel_size_m;
    finest = std::min(finest.value_or(pixel_size_m), pixel_size_m);
  }
  return finest;
}

double FlightPicture::NeededPixelSize() const {
  if (const auto pixel_size_m = PhotoPixelSize()) return *pixel_size_m;
  throw ApiError("NoMap", "the flight has no layer photo");
}

// Maps may differ in their finest pixels: of each map, the level with pixels of this size.
std::vector<PhotoWindow> FlightPicture::PhotoWindows(const WorldBox& box,
                                                     double pixel_size_m) const {
  stop_if_unwanted_();
  std::vector<PhotoWindow> windows;
  for (const auto& map : maps_) {
    if (!map->head.photo) continue;
    const double ratio = pixel_size_m / map->head.photo->pixel_size_m;
    const int level = std::clamp(
        static_cast<int>(std::floor(std::log2(ratio) + 0.01)), 0, map->head.photo->num_levels - 1);
    std::vector<PhotoWindow> some =
        service_.maps.flight_maps().ReadPhoto(service_.storage, *map, level, box);
    std::move(some.begin(), some.end(), std::back_inserter(windows));
  }
  return windows;
}

PhotoSource FlightPicture::SourceOfPhoto() const {
  const double finest_m = NeededPixelSize();
  int num_levels = 1;
  for (const auto& map : maps_) {
    if (map->head.photo) num_levels = std::max(num_levels, map->head.photo->num_levels);
  }
  const auto windows_of = [this, finest_m](const WorldBox& box, int level) {
    return PhotoWindows(box, std::ldexp(finest_m, level));
  };
  return {Extent(), finest_m, num_levels, windows_of, {}};
}

// Neighbours in a row of tiles share a box.
std::vector<WorldBox> FlightPicture::PhotoParts() const {
  std::vector<WorldBox> parts;
  for (const auto& map : maps_) {
    if (!map->head.photo) continue;
    std::optional<TileKey> last;
    for (const auto& [key, file] : service_.storage.maps.ListPhotoTiles(map->row.id, 0)) {
      const MapTileIndex index{0, static_cast<int>(key.row), static_cast<int>(key.col)};
      const WorldBox box = BoxOfGrid(map->head.photo->GridOf(index));
      if (last == TileKey{0, key.row, key.col - 1}) {
        parts.back() = Joined(parts.back(), box);
      } else {
        parts.push_back(box);
      }
      last = key;
    }
  }
  return parts;
}

std::string FlightPicture::PhotoTile(const XyzTile& tile, const std::string& content_type) const {
  const PhotoSource source = SourceOfPhoto();
  std::vector<PhotoWindow> windows;
  if (const auto box = WorldBoxOf(tile, Frame())) {
    const int level = LevelOf(tile, Frame(), source.finest_pixel_size_m, source.num_levels);
    windows = source.windows_of(*box, level);
  }
  return content_type == "image/jpeg" ? PhotoTileJpeg(tile, windows, Frame())
                                      : PhotoTilePng(tile, windows, Frame());
}

nlohmann::json FlightPicture::Json(const std::string& base_url) const {
  MapDescription description;
  description.base_url = base_url;
  description.extent = Extent();
  description.cell_size_m = maps_.front()->head.grid.cell_size_m;
  description.photo_pixel_size_m = PhotoPixelSize();
  for (const std::string& layer : MapLayerNames()) {
    if (const auto scale = ScaleOf(layer)) description.scales.emplace_back(layer, *scale);
  }
  description.updated_at = Rfc3339(updated_at_us_);
  return MapJson(description, Frame());
}

std::string FlightPicture::Tile(const std::string& layer,
                                const XyzTile& tile,
                                const std::string& content_type) const {
  if (layer == "photo") return PhotoTile(tile, content_type);
  const Scale scale = NeededScale(layer);
  std::vector<MapWindow> windows;
  if (const auto box = WorldBoxOf(tile, Frame())) {
    const int level = LevelOf(tile, Frame(), maps_.front()->head.grid.cell_size_m, NumLevels());
    windows = Windows(layer, *box, level);
  }
  return MapTilePng(layer, tile, windows, scale, Frame());
}

void FlightPicture::RequireLayer(const std::string& layer) const {
  if (layer == "photo") {
    NeededPixelSize();
  } else {
    NeededScale(layer);
  }
}

void FlightPicture::WriteGeoTiff(const std::string& layer,
                                 const std::filesystem::path& file) const {
  RequireLayer(layer);
  if (layer == "photo") {
    PhotoSource source = SourceOfPhoto();
    source.parts = PhotoParts();
    return WritePhotoGeoTiff(file.string(), source, Frame());
  }
  MapSource source = Source(layer);
  for (const auto& map : maps_) source.parts.push_back(BoxOfGrid(map->head.grid));
  WriteLayerGeoTiff(file.string(), layer, source, Frame());
}

std::string FlightPicture::Kmz(const std::string& layer) const {
  if (layer == "photo") {
    return PhotoKmz(flight_id_ + " photo", SourceOfPhoto(), Frame());
  }
  return MapKmz(flight_id_ + " " + layer, layer, Source(layer), NeededScale(layer), Frame());
}

std::string FlightPicture::PhotoOf(const WorldBox& box, int longest_px) const {
  const std::optional<double> finest_m = PhotoPixelSize();
  if (!finest_m) return "";
  // Pixels of one of the picture's levels.
  double pixel_size_m = *finest_m;
  while (pixel_size_m < PixelSizeOf(box, longest_px)) pixel_size_m *= 2.0;
  const std::vector<PhotoWindow> windows = PhotoWindows(box, pixel_size_m);
  return windows.empty() ? "" : PhotoBoxJpeg(box, pixel_size_m, windows, Frame());
}

std::string FlightPicture::HazardOf(const WorldBox& box, int longest_px, Backdrop backdrop) const {
  const double pixel_size_m = PixelSizeOf(box, longest_px);
  return HazardBoxPng(
      box, pixel_size_m, WindowsFor("hazard", box, pixel_size_m), backdrop, Frame());
}

std::string FlightPicture::LayerOf(const std::string& layer,
                                   const WorldBox& box,
                                   int longest_px) const {
  const std::optional<Scale> scale = ScaleOf(layer);
  if (!scale) return "";
  const double pixel_size_m = PixelSizeOf(box, longest_px);
  return LayerBoxPng(
      layer, box, pixel_size_m, WindowsFor(layer, box, pixel_size_m), *scale, Frame());
}

std::string FlightPicture::Legend(const std::string& layer) const {
  return MapLegendPng(layer, NeededScale(layer));
}

}  // namespace freelsd
