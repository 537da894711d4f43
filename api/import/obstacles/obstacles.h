// Bytes -> obstacles that photographs do not show, and back. Every function here treats its input
// as hostile.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "api/api.h"

namespace freelsd {

// kWiresKnown is no obstacle: it is an area whose power lines, towers and masts are all stored.
enum class ObstacleKind { kWire, kMast, kNoFly, kPeople, kWiresKnown };

// Names and units as in openapi.yaml.
struct GivenObstacle {
  // Empty if a feature of a collection has none.
  std::string id;
  ObstacleKind kind = ObstacleKind::kWire;
  std::string name;
  // A Point has one. Those of a line or ring are in order, and a ring does not repeat its first
  // point. The altitude is that of the top (people: of their ground), in altitude_datum, or NaN if
  // it is not given.
  std::vector<GeoPoint> points;
  bool is_area = false;
  // Of the top above ground, for a wire or a mast.
  std::optional<double> height_m;
  // Of an airspace, in altitude_datum or above ground. No floor: it begins at the ground. No
  // ceiling: it is unlimited.
  std::optional<double> floor_m;
  std::optional<double> ceiling_m;
  std::optional<double> floor_above_ground_m;
  std::optional<double> ceiling_above_ground_m;
  std::string altitude_datum = "unknown";
  // Standard deviation of the horizontal position.
  double position_sd_m = 0.0;
  // From this time on, the obstacle does not count.
  std::optional<int64_t> expires_at_us;
};

// A GeoJSON feature of a request. `pointer` is its place in the body. Throws ApiError.
GivenObstacle ParseObstacle(const nlohmann::json& feature, const std::string& pointer);
// The obstacle as a GeoJSON feature, for answers and storage.
nlohmann::json ObstacleFeature(const GivenObstacle& obstacle);
// Reads the same obstacle back. It accepts shapes and names that a request may not have, because
// OpenAir files have them. Throws ApiError.
GivenObstacle ParseStoredObstacle(const nlohmann::json& feature);

struct ImportedObstacles {
  std::vector<GivenObstacle> obstacles;
  std::vector<std::string> warnings;
};
// A GeoJSON FeatureCollection: of our own features, or of OpenStreetMap's with their tags. Throws
// ApiError.
ImportedObstacles ParseObstacles(const std::string& text);
// True if the feature has OpenStreetMap's tags and no kind of ours.
bool IsOpenStreetMap(const nlohmann::json& feature);
// OpenStreetMap's power lines, aerial ways, towers, masts, poles, chimneys and wind turbines as
// wires and masts. Where a height is not tagged, that of its kind is taken, rather too high than
// too low; a warning tells which. All other features are left out with a warning. The collection's
// bbox, or else the box around all its features, becomes an area of kWiresKnown.
ImportedObstacles ImportOpenStreetMap(const nlohmann::json& collection);
// True if the text begins as OpenAir does: a comment, or a command that begins an airspace.
bool IsOpenAir(std::string_view text);
// OpenAir: airspaces as no_fly. A flight level counts as its altitude above mean sea level in the
// standard atmosphere. An airspace that cannot be read is left out with a warning, and so are
// unknown records; one across the antimeridian becomes two. A border that crosses itself causes a
// warning; in the file of a whole country, an arc around the inside may do so. Throws ApiError with
// the number of a line if no airspace can be read.
ImportedObstacles ParseOpenAir(std::string_view text);

}  // namespace freelsd
