#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <nlohmann/json.hpp>

#include "api/export/map/map_layer.h"
#include "api/export/map/outline.h"
#include "api/export/map/web_mercator.h"

namespace freelsd {
namespace {

// Of tiles that a client asks for; beyond it enlarges them.
constexpr int kMaxTileZoom = 24;
// Least size of the map in the tiles of the lowest zoom.
constexpr double kMinMapSizePx = 16.0;

// Highest zoom at which the map is not larger than the given number of pixels.
int MinZoom(const WorldBox& extent, double latitude_deg) {
  const double size_m = (extent.max_in_world - extent.min_in_world).maxCoeff();
  const double zoom = std::log2(kMinMapSizePx * PixelSizeM(0, latitude_deg) / size_m);
  return static_cast<int>(std::clamp(std::ceil(zoom), 0.0, 1.0 * kMaxTileZoom));
}

// Lowest zoom whose pixels are not larger than the given size.
int MaxZoom(double pixel_size_m, double latitude_deg) {
  const double zoom = std::log2(PixelSizeM(0, latitude_deg) / pixel_size_m);
  return static_cast<int>(std::clamp(std::ceil(zoom), 0.0, 1.0 * kMaxTileZoom));
}

void CheckDescription(const MapDescription& map) {
  CheckExtent(map.extent);
  const auto check = [](const char* name, double value) {
    if (std::isfinite(value) && value > 0.0) return;
    throw std::invalid_argument("map." + std::string(name) + " = " + std::to_string(value) +
                                ": must be positive");
  };
  check("cell_size_m", map.cell_size_m);
  if (map.photo_pixel_size_m) check("photo_pixel_size_m", *map.photo_pixel_size_m);
}

// What all layers have.
nlohmann::json TileJson(const MapDescription& map,
                        const std::string& name,
                        int max_zoom,
                        const LocalFrame& local_frame) {
  const GeoBounds bounds = BoundsOf(map.extent, local_frame);
  const GeoPoint center = CenterOf(map.extent, local_frame);
  const int min_zoom = std::min(max_zoom, MinZoom(map.extent, local_frame.origin().latitude_deg));
  const std::string layer_url = map.base_url + "/" + name;
  const int center_zoom = std::clamp(min_zoom + 4, min_zoom, max_zoom);
  nlohmann::json json{
      {"tilejson", "3.0.0"},
      {"name", name},
      {"unit", UnitOf(MapLayerOf(name))},
      {"scheme", "xyz"},
      {"tiles", {layer_url + "/{z}/{x}/{y}.png"}},
      {"geotiff", layer_url + ".tif"},
      {"bounds", {bounds.west_deg, bounds.south_deg, bounds.east_deg, bounds.north_deg}},
      {"center", {center.longitude_deg, center.latitude_deg, center_zoom}},
      {"minzoom", min_zoom},
      {"maxzoom", max_zoom}};
  if (name == "photo" || name == "hazard") json["kmz"] = layer_url + ".kmz";
  if (map.attribution) json["attribution"] = *map.attribution;
  return json;
}

}  // namespace

nlohmann::json MapJson(const MapDescription& map, const LocalFrame& local_frame) {
  CheckDescription(map);
  const double latitude_deg = local_frame.origin().latitude_deg;
  nlohmann::json layers = nlohmann::json::array();
  if (map.photo_pixel_size_m) {
    nlohmann::json photo =
        TileJson(map, "photo", MaxZoom(*map.photo_pixel_size_m, latitude_deg), local_frame);
    photo["min"] = photo["max"] = photo["legend"] = nullptr;
    layers.push_back(photo);
  }
  // Pixels of half a cell show its edges where they are.
  const int max_zoom = MaxZoom(0.5 * map.cell_size_m, latitude_deg);
  for (const auto& [name, scale] : map.scales) {
    ValueLayerOf(name);
    CheckScale(scale);
    nlohmann::json layer = TileJson(map, name, max_zoom, local_frame);
    layer["min"] = scale.min;
    layer["max"] = scale.max;
    layer["legend"] = map.base_url + "/" + name + "/legend.png";
    layers.push_back(layer);
  }
  return {{"layers", layers}, {"updated_at", map.updated_at}};
}

}  // namespace freelsd
