// Engine types -> bytes: pictures of layers, GeoTIFF, and the stored form of a site's map.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "engine/hazard/hazard.h"

namespace freelsd {

// The part of an evaluation's map around one site: what is stored, drawn and planned on again.
struct SiteMap {
  ElevationMap map;
  HazardLayers layers;
};

// Crop to the smallest box that holds `footprint` and every seen cell within margin_m of it.
SiteMap CropAround(const ElevationMap& map,
                   const HazardLayers& layers,
                   const Polygon& footprint,
                   double margin_m);

// Compressed, versioned; Deserialize throws std::runtime_error on anything else.
std::string SerializeSiteMap(const SiteMap& site_map);
SiteMap DeserializeSiteMap(const std::string& bytes);

// "elevation", "slope", "roughness", "grass", "hazard", "distance".
std::vector<std::string> LayerNames();
struct LayerInfo {
  std::string name;
  std::string unit;
  // Of seen cells; nothing when none is.
  std::optional<double> min;
  std::optional<double> max;
};
LayerInfo DescribeLayer(const SiteMap& site_map, const std::string& name);
// {layers: [...]} of the contract: units, ranges, size, bounds, corners.
nlohmann::json LayersJson(const SiteMap& site_map, const LocalFrame& local_frame);
// Picture for people, north up, one pixel per cell; unseen cells transparent, but in hazard and
// distance opaque in a colour of their own.
std::string LayerPng(const SiteMap& site_map, const std::string& name);
std::string LegendPng(const SiteMap& site_map, const std::string& name);
// float32, UTM, NaN unseen; elevation as altitude in the flight's datum.
std::string LayerGeoTiff(const SiteMap& site_map,
                         const std::string& name,
                         const LocalFrame& local_frame);

}  // namespace freelsd
