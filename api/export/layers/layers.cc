#include <cmath>
#include <limits>
#include <stdexcept>

#include <nlohmann/json.hpp>

#include "api/export/layers/layer_values.h"
#include "api/export/utm.h"

namespace freelsd {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
// Mean radius of the earth, m. Over a few kilometres its error is below a millimetre.
constexpr double kEarthRadiusM = 6371000.0;

struct LayerUnit {
  const char* name;
  const char* unit;
};

constexpr LayerUnit kLayers[] = {
    {"elevation", "m"},
    {"slope", "deg"},
    {"roughness", "m"},
    {"grass", "class"},
    {"hazard", "class"},
    {"distance", "m"},
};

cv::Mat1f BinaryGrass(const HazardLayers& layers) {
  const cv::Mat1f& posterior = layers.grass;
  cv::Mat1f binary(posterior.size());
  for (int row = 0; row < binary.rows; ++row) {
    for (int col = 0; col < binary.cols; ++col) {
      const float value = posterior(row, col);
      binary(row, col) =
          std::isnan(value) ? kNaN : (value >= layers.min_grass_posterior ? 1.0f : 0.0f);
    }
  }
  return binary;
}

cv::Mat1f SlopeDegrees(const cv::Mat1f& slope) {
  cv::Mat1f degrees = slope.clone();
  for (float& value : degrees) value = static_cast<float>(DegFromRad(value));
  return degrees;
}

cv::Mat1f SeenDistance(const SiteMap& site_map) {
  cv::Mat1f distance = site_map.layers.distance.clone();
  if (!distance.empty()) distance.setTo(kNaN, site_map.layers.hazard == kUnseen);
  return distance;
}

nlohmann::json NumberOrNull(const std::optional<double>& number, double offset) {
  return number ? nlohmann::json(*number + offset) : nlohmann::json(nullptr);
}

// Corners as lon, lat, and the box around them as west, south, east, north. Its longitudes are near
// the origin's and may leave [-180, 180].
struct Placement {
  nlohmann::json corners = nlohmann::json::array();
  nlohmann::json bounds;
};

Placement Place(const Grid& grid, const LocalFrame& local_frame) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  double west = kInfinity, south = kInfinity, east = -kInfinity, north = -kInfinity;
  const double origin_deg = local_frame.origin().longitude_deg;
  Placement placement;
  for (const Eigen::Vector2d& corner : OuterCorners(grid)) {
    const GeoPoint geo = local_frame.GeoFromWorld({corner.x(), corner.y(), 0.0});
    placement.corners.push_back({geo.longitude_deg, geo.latitude_deg});
    const double turns = std::round((geo.longitude_deg - origin_deg) / 360.0);
    west = std::min(west, geo.longitude_deg - 360.0 * turns);
    east = std::max(east, geo.longitude_deg - 360.0 * turns);
    south = std::min(south, geo.latitude_deg);
    north = std::max(north, geo.latitude_deg);
  }
  placement.bounds = {west, south, east, north};
  return placement;
}

}  // namespace

double AltitudeOfPlane(const Eigen::Vector2d& place_in_world, const LocalFrame& local_frame) {
  return local_frame.origin().altitude_m + place_in_world.squaredNorm() / (2.0 * kEarthRadiusM);
}

std::vector<Eigen::Vector2d> OuterCorners(const Grid& grid) {
  const Eigen::Vector2d north_west = grid.north_west_in_world;
  const double width = grid.num_cols * grid.cell_size_m;
  const double height = grid.num_rows * grid.cell_size_m;
  return {north_west,
          north_west + Eigen::Vector2d(width, 0.0),
          north_west + Eigen::Vector2d(width, -height),
          north_west + Eigen::Vector2d(0.0, -height)};
}

cv::Mat1f LayerValues(const SiteMap& site_map, const std::string& name) {
  if (name == "elevation") return site_map.map.elevation.clone();
  if (name == "slope") return SlopeDegrees(site_map.layers.slope);
  if (name == "roughness") return site_map.layers.roughness.clone();
  if (name == "grass") return BinaryGrass(site_map.layers);
  if (name == "distance") return SeenDistance(site_map);
  if (name != "hazard") throw std::invalid_argument("layer = " + name + ": no such layer");
  cv::Mat1f hazard;
  site_map.layers.hazard.convertTo(hazard, CV_32F);
  return hazard;
}

std::vector<std::string> LayerNames() {
  std::vector<std::string> names;
  for (const LayerUnit& layer : kLayers) names.emplace_back(layer.name);
  return names;
}

LayerInfo DescribeLayer(const SiteMap& site_map, const std::string& name) {
  LayerInfo info{name, "", std::nullopt, std::nullopt};
  for (const LayerUnit& layer : kLayers) {
    if (name == layer.name) info.unit = layer.unit;
  }
  cv::Mat1f values = LayerValues(site_map, name);
  if (name == "hazard" && !values.empty()) values.setTo(kNaN, site_map.layers.hazard == kUnseen);
  for (const float value : values) {
    if (!std::isfinite(value)) continue;
    info.min = std::min<double>(info.min.value_or(value), value);
    info.max = std::max<double>(info.max.value_or(value), value);
  }
  return info;
}

nlohmann::json LayersJson(const SiteMap& site_map, const LocalFrame& local_frame) {
  nlohmann::json layers = nlohmann::json::array();
  const Grid& grid = site_map.map.grid;
  if (grid.num_rows == 0 || grid.num_cols == 0) return {{"layers", layers}};
  const Placement placement = Place(grid, local_frame);
  const std::vector<Eigen::Vector2d> corners = OuterCorners(grid);
  const int epsg = ZoneOf(local_frame.origin()).Epsg();
  const double altitude = AltitudeOfPlane(0.5 * (corners[0] + corners[2]), local_frame);
  for (const std::string& name : LayerNames()) {
    const LayerInfo info = DescribeLayer(site_map, name);
    const double offset = name == "elevation" ? altitude : 0.0;
    layers.push_back({{"name", info.name},
                      {"unit", info.unit},
                      {"min", NumberOrNull(info.min, offset)},
                      {"max", NumberOrNull(info.max, offset)},
                      {"width_px", grid.num_cols},
                      {"height_px", grid.num_rows},
                      {"cell_size_m", grid.cell_size_m},
                      {"epsg", epsg},
                      {"bounds", placement.bounds},
                      {"corners", placement.corners}});
  }
  return {{"layers", layers}};
}

}  // namespace freelsd
