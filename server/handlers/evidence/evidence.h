// What a cell of a flight's map was made of, as JSON. Private to handlers.
#pragma once

#include <optional>
#include <string>

#include <nlohmann/json.hpp>

#include "engine/approach/approach.h"
#include "server/handlers/handlers.h"
#include "server/maps/maps.h"

namespace freelsd {

// A place of a map with its height, which is known.
struct CellOnMap {
  const FlightMap& map;
  Eigen::Vector2d place_in_world;
  double height = 0.0;
};

// `frames` that show the place; `patches`: where each shows it, with its weight and the address of
// the part of it that is cut out there; `context_frames`, null if no photographs were matched;
// `cues`, null if the map has none; `height_likelihood`, null where photographs are missing or
// fewer than two show the place.
nlohmann::json CellEvidenceJson(Service& service, const CellOnMap& cell);

// The part of the risk that is nearest to its limit; null without a risk.
nlohmann::json NearestLimitJson(const PlaceJudgement& judgement, const Aircraft& aircraft);

// The options that the flight was given, and the versions that made the map: the others are the
// defaults of these versions.
nlohmann::json OptionsOfMapJson(const MapHead& head);
nlohmann::json VersionsOfMapJson(const FlightMap& map);

}  // namespace freelsd
