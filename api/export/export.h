// Engine types -> bytes: pictures of layers, GeoTIFF, and the stored form of a site's map. Stored
// sites -> the formats of other programs, and a report for people.
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

// Crop to the smallest box that holds `footprint` and every seen cell within margin_m of it. Empty
// where the footprint is, or where the map has nothing of it.
SiteMap CropAround(const ElevationMap& map,
                   const HazardLayers& layers,
                   const Polygon& footprint,
                   double margin_m);

// What is stored is not what was written.
class DamagedMap : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};
// Compressed, versioned, with a checksum; Deserialize throws DamagedMap on anything else, and
// std::runtime_error on another version, before it allocates more than the bytes can hold.
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
// In the values of the GeoTIFF, but elevation is world z. Here and below: std::invalid_argument for
// a name that is no layer.
LayerInfo DescribeLayer(const SiteMap& site_map, const std::string& name);
// {layers: [...]} of the contract: units, ranges, size, bounds, corners; elevation as altitude. An
// empty map gives {layers: []}.
nlohmann::json LayersJson(const SiteMap& site_map, const LocalFrame& local_frame);
// Picture for people, north up, one pixel per cell, RGBA; unseen cells transparent, but in hazard
// and distance opaque in a colour of their own. Colours are told apart by the colour-blind.
std::string LayerPng(const SiteMap& site_map, const std::string& name);
// Its scale with values and unit. `altitude_of_world_m` (the origin's altitude) is added to
// heights.
std::string LegendPng(const SiteMap& site_map,
                      const std::string& name,
                      double altitude_of_world_m = 0.0);
// float32, UTM zone of the origin (WGS84; UPS near the poles), NaN unseen; elevation as altitude in
// the flight's datum. `hazard` is 0 free, 1 hazard, 2 unseen; `grass` 1 from the default posterior
// on, else 0. The rows are those of the local grid: the transformation is a full affine one.
std::string LayerGeoTiff(const SiteMap& site_map,
                         const std::string& name,
                         const LocalFrame& local_frame);
// World file of the layers' pictures: six lines, in the CRS of the GeoTIFFs, which
// {epsg} of LayersJson names. std::invalid_argument for an empty map.
std::string LayerWorldFile(const SiteMap& site_map, const LocalFrame& local_frame);

// --- Sites in the formats of other programs ---

struct StoredSite {
  // GeoJSON feature, with rank.
  std::string feature_json;
  // FeatureCollection of ApproachJson; empty where there is none.
  std::string approach_json;
  std::string altitude_datum = "unknown";
};
struct ExportOptions {
  // Of the place of launch, in the sites' datum: autopilots' files then tell altitudes above it.
  std::optional<double> home_altitude_m;
};
struct SiteFormat {
  const char* name;
  const char* media_type;
  const char* extension;
  // Whether the file itself says of each site that it is unverified; else its name has to.
  bool tells_verdicts = true;
};
// plan, waypoints, rally, kml, cup, csv.
std::vector<SiteFormat> SiteFormats();
// `sites` of one flight, best first. What something would fly to (plan, waypoints, rally, cup)
// never holds a rejected site, and an unverified one is named so. Throws ApiError SiteRejected
// where nothing is left, NoApproach, AltitudeUnknown where the format needs a reference that is not
// known; std::invalid_argument for another name.
std::string ExportSites(const std::string& format,
                        const std::vector<StoredSite>& sites,
                        const ExportOptions& options);
// One page of HTML that asks for nothing else: verdict, map with layers, profile, numbers.
// `site_map` may be empty.
std::string SiteReport(const StoredSite& site,
                       const SiteMap& site_map,
                       const LocalFrame& local_frame);

}  // namespace freelsd
