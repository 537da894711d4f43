// The bytes of a flight's map as servers pass them on: the same on every server that has the map.
#pragma once

#include <string>

#include "storage/storage.h"

namespace freelsd {

// A line that names the form, a line of JSON (the row and the sizes of the tiles), and the tiles. A
// tile that is damaged in both copies is left out: its ground is unseen. The picture is no part.
std::string MapBytes(const Storage& storage, const FlightMapRow& map);

struct TakenMap {
  FlightMapRow map;
  Tiles tiles;
};
// Throws ApiError InvalidValue if the bytes are no map of that id, or a tile is damaged.
TakenMap ParseMapBytes(const std::string& bytes, const std::string& map_id);

}  // namespace freelsd
