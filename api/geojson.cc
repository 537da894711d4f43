#include "api/geojson.h"

#include <algorithm>
#include <cmath>

namespace freelsd {
namespace {

// Steps per degree; one step is a tenth of a millimetre.
constexpr double kDegreeSteps = 1e9;
constexpr double kThousandth = 1e3;

double RoundedDegrees(double degrees) { return std::round(degrees * kDegreeSteps) / kDegreeSteps; }

}  // namespace

nlohmann::json NumberOrNull(double number) {
  return std::isfinite(number) ? nlohmann::json(number) : nlohmann::json(nullptr);
}

nlohmann::json Rounded(double number) {
  return NumberOrNull(std::round(number * kThousandth) / kThousandth);
}

nlohmann::json PositionJson(const Eigen::Vector3d& point_in_world, const LocalFrame& local_frame) {
  const GeoPoint place = local_frame.GeoFromWorld(point_in_world);
  return {RoundedDegrees(place.longitude_deg),
          RoundedDegrees(place.latitude_deg),
          Rounded(place.altitude_m)};
}

double AltitudeOf(const Eigen::Vector3d& point_in_world, const LocalFrame& local_frame) {
  return local_frame.GeoFromWorld(point_in_world).altitude_m;
}

nlohmann::json PlaceJson(const Eigen::Vector3d& point_in_world, const LocalFrame& local_frame) {
  if (!point_in_world.allFinite()) return nullptr;
  const GeoPoint place = local_frame.GeoFromWorld(point_in_world);
  return {{"latitude_deg", RoundedDegrees(place.latitude_deg)},
          {"longitude_deg", RoundedDegrees(place.longitude_deg)},
          {"altitude_m", Rounded(place.altitude_m)}};
}

nlohmann::json PointGeometry(const Eigen::Vector3d& point_in_world, const LocalFrame& local_frame) {
  if (!point_in_world.allFinite()) return nullptr;
  return {{"type", "Point"}, {"coordinates", PositionJson(point_in_world, local_frame)}};
}

nlohmann::json LineGeometry(const std::vector<Eigen::Vector3d>& line_in_world,
                            const LocalFrame& local_frame) {
  nlohmann::json coordinates = nlohmann::json::array();
  for (const Eigen::Vector3d& point : line_in_world) {
    coordinates.push_back(PositionJson(point, local_frame));
  }
  return {{"type", "LineString"}, {"coordinates", coordinates}};
}

nlohmann::json PolygonGeometry(std::vector<Eigen::Vector3d> ring_in_world,
                               const LocalFrame& local_frame) {
  const bool is_finite = std::all_of(ring_in_world.begin(),
                                     ring_in_world.end(),
                                     [](const auto& corner) { return corner.allFinite(); });
  if (ring_in_world.size() < 3 || !is_finite) return nullptr;
  Polygon footprint;
  for (const Eigen::Vector3d& corner : ring_in_world) footprint.emplace_back(corner.head<2>());
  if (SignedArea(footprint) < 0.0) std::reverse(ring_in_world.begin(), ring_in_world.end());
  ring_in_world.push_back(ring_in_world.front());
  nlohmann::json ring = LineGeometry(ring_in_world, local_frame)["coordinates"];
  nlohmann::json rings = nlohmann::json::array();
  rings.push_back(std::move(ring));
  return {{"type", "Polygon"}, {"coordinates", std::move(rings)}};
}

nlohmann::json Feature(const nlohmann::json& geometry, const nlohmann::json& properties) {
  return {{"type", "Feature"}, {"geometry", geometry}, {"properties", properties}};
}

nlohmann::json FeatureCollection(const std::vector<nlohmann::json>& features) {
  nlohmann::json list = nlohmann::json::array();
  for (const nlohmann::json& feature : features) list.push_back(feature);
  return {{"type", "FeatureCollection"}, {"features", std::move(list)}};
}

nlohmann::json WindJson(const std::optional<WindEstimate>& wind) {
  if (!wind || !wind->wind_in_world.allFinite()) return nullptr;
  return {{"east_mps", Rounded(wind->wind_in_world.x())},
          {"north_mps", Rounded(wind->wind_in_world.y())}};
}

}  // namespace freelsd
