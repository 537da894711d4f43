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

enum class ObstacleKind { kWire, kMast, kNoFly, kPeople };

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
  // Of an airspace, in altitude_datum. No floor: it begins at the ground. No ceiling: it is
  // unlimited.
  std::optional<double> floor_m;
  std::optional<double> ceiling_m;
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
// A GeoJSON FeatureCollection. Throws ApiError.
ImportedObstacles ParseObstacles(const std::string& text);
// True if the text begins as OpenAir does: a comment, or a command that begins an airspace.
bool IsOpenAir(std::string_view text);
// OpenAir: airspaces as no_fly. A floor given above ground counts as the ground, and a ceiling
// given above ground as unlimited; each causes a warning. A flight level counts as its altitude
// above mean sea level in the standard atmosphere. A border that crosses itself causes a warning
// too; in the file of a whole country, an arc around the inside may do so. Throws ApiError with the
// number of the line.
ImportedObstacles ParseOpenAir(std::string_view text);

}  // namespace freelsd
