// GeoJSON (RFC 7946) from places in world: longitude, latitude, altitude; rings counter-clockwise.
#pragma once

#include <vector>

#include <nlohmann/json.hpp>

#include "api/api.h"

namespace freelsd {

// Null where the number is not finite: unknown is never a number.
nlohmann::json NumberOrNull(double number);
// Rounded to a thousandth (millimetres, millidegrees, ...), or null.
nlohmann::json Rounded(double number);

// [longitude, latitude, altitude].
nlohmann::json PositionJson(const Eigen::Vector3d& point_in_world, const LocalFrame& local_frame);
// Altitude of a place in world, in the flight's datum.
double AltitudeOf(const Eigen::Vector3d& point_in_world, const LocalFrame& local_frame);
// {latitude_deg, longitude_deg, altitude_m}; null when the place is not finite.
nlohmann::json PlaceJson(const Eigen::Vector3d& point_in_world, const LocalFrame& local_frame);
nlohmann::json PointGeometry(const Eigen::Vector3d& point_in_world, const LocalFrame& local_frame);
nlohmann::json LineGeometry(const std::vector<Eigen::Vector3d>& line_in_world,
                            const LocalFrame& local_frame);
// Closed and turned counter-clockwise. `ring` is open; null with fewer than three corners.
nlohmann::json PolygonGeometry(std::vector<Eigen::Vector3d> ring_in_world,
                               const LocalFrame& local_frame);
nlohmann::json Feature(const nlohmann::json& geometry, const nlohmann::json& properties);
nlohmann::json FeatureCollection(const std::vector<nlohmann::json>& features);
// {east_mps, north_mps}, or null.
nlohmann::json WindJson(const std::optional<WindEstimate>& wind);

}  // namespace freelsd
