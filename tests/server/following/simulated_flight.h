// What a server tells of a flight, without the engine: a small field, its map and a landing that is
// planned on it.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "server/following/following.h"

namespace freelsd {

enum class FieldState { kFree, kWalled };

struct SimulatedFlight {
  std::string id;
  // Where: fields lie beside each other at 47 degrees north.
  double longitude_deg = 8.0;
  // When the ground was photographed; also when it was evaluated.
  int64_t seen_at_us = 0;
  FieldState field = FieldState::kFree;
  // Otherwise its map alone.
  bool has_site = true;
  std::string origin = "aircraft";
  // Of the flight's maps.
  int map_number = 1;
};

// Changes as a server tells them, and the bytes of the maps.
struct ToldFlight {
  std::vector<ToldChange> changes;
  std::map<std::string, std::string> map_bytes;
};
ToldFlight Fly(const SimulatedFlight& flight);

}  // namespace freelsd
