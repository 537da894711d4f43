// GeoJSON (RFC 7946) from points in world: longitude, latitude, altitude; rings counter-clockwise.
#pragma once

#include <vector>

#include <nlohmann/json.hpp>

#include "api/api.h"

namespace freelsd {

// Null if the number is not finite: the engine marks unknown values by NaN.
nlohmann::json NumberOrNull(double number);
// Rounded to a thousandth of the unit; null if the number is not finite.
nlohmann::json Rounded(double number);

// [longitude, latitude, altitude].
nlohmann::json PositionJson(const Eigen::Vector3d& point_in_world, const LocalFrame& local_frame);
// Altitude of a point, in the flight's datum.
double AltitudeOf(const Eigen::Vector3d& point_in_world, const LocalFrame& local_frame);
// {latitude_deg, longitude_deg, altitude_m}; null if the point is not finite.
nlohmann::json PlaceJson(const Eigen::Vector3d& point_in_world, const LocalFrame& local_frame);
nlohmann::json PointGeometry(const Eigen::Vector3d& point_in_world, const LocalFrame& local_frame);
nlohmann::json LineGeometry(const std::vector<Eigen::Vector3d>& line_in_world,
                            const LocalFrame& local_frame);
// A closed ring, counter-clockwise. `ring_in_world` is open. Null if it has fewer than 3 corners.
nlohmann::json PolygonGeometry(std::vector<Eigen::Vector3d> ring_in_world,
                               const LocalFrame& local_frame);
nlohmann::json Feature(const nlohmann::json& geometry, const nlohmann::json& properties);
nlohmann::json FeatureCollection(const std::vector<nlohmann::json>& features);
// {east_mps, north_mps}; null if the wind is unknown.
nlohmann::json WindJson(const std::optional<WindEstimate>& wind);

}  // namespace freelsd
