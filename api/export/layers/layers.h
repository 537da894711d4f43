// Layers of a site's map -> pictures, GeoTIFFs and world files.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "api/stored/stored.h"

namespace freelsd {

// Crops to the smallest box that contains `footprint` and every seen cell within margin_m of it.
// The result is empty if the footprint is empty or lies outside the map.
SiteMap CropAround(const ElevationMap& map,
                   const HazardLayers& layers,
                   const Polygon& footprint,
                   double margin_m);

// Outer corners of the grid in world, clockwise from the north-west.
std::vector<Eigen::Vector2d> OuterCorners(const Grid& grid);

// Altitude of the plane z = 0 of world at a place. It varies from place to place, because the plane
// is tangent to the curved earth.
double AltitudeOfPlane(const Eigen::Vector2d& place_in_world, const LocalFrame& local_frame);

// Values of a layer at the two ends of the ramp of colours of its picture.
struct Scale {
  double min = 0.0;
  double max = 1.0;
};

// "elevation", "slope", "roughness", "grass", "hazard", "distance".
std::vector<std::string> LayerNames();
struct LayerInfo {
  std::string name;
  std::string unit;
  // Range of the seen cells; nothing if no cell is seen.
  std::optional<double> min;
  std::optional<double> max;
};
// Unit and range of a layer. Values are those of the GeoTIFF, except that elevation is world z.
// This function and the ones below throw std::invalid_argument if no layer has the name.
LayerInfo DescribeLayer(const SiteMap& site_map, const std::string& name);
// {layers: [...]} of openapi.yaml: units, ranges, size, bounds, corners. Elevation is an altitude.
// An empty map gives {layers: []}.
nlohmann::json LayersJson(const SiteMap& site_map, const LocalFrame& local_frame);
// Picture for people: RGBA, north up, one pixel per cell. Unseen cells are transparent. Exception:
// in the layers hazard and distance they have an opaque colour. Colour-blind people can distinguish
// the colours.
std::string LayerPng(const SiteMap& site_map, const std::string& name);
// Legend of the picture with values and unit. `altitude_of_world_m` is the origin's altitude. It is
// added to elevations.
std::string LegendPng(const SiteMap& site_map,
                      const std::string& name,
                      double altitude_of_world_m = 0.0);
// float32 in the origin's UTM zone (WGS84; UPS near the poles). Unseen cells are NaN. Elevation is
// an altitude in the flight's datum. `hazard` is 0 free, 1 hazard, 2 unseen. `grass` is 1 at or
// above the map's min_grass_posterior, else 0. Rows follow the local grid, so the transform is
// affine.
std::string LayerGeoTiff(const SiteMap& site_map,
                         const std::string& name,
                         const LocalFrame& local_frame);
// World file of the layers' pictures: six lines, in the CRS of the GeoTIFFs (`epsg` in
// LayersJson). Throws std::invalid_argument for an empty map.
std::string LayerWorldFile(const SiteMap& site_map, const LocalFrame& local_frame);

}  // namespace freelsd
