// Values in OpenAir files. Private to obstacles/.
#pragma once

#include <optional>
#include <string_view>

#include "engine/geometry/geometry.h"

namespace freelsd {

// Reads "47:35:24 N 007:31:12 E", "47:35.4N 7:31.2E", "N47 35 24 E7 31 12" or "47.59 N, 7.52 E".
// The result's altitude is 0. Nothing for any other text.
std::optional<GeoPoint> CoordinatesFromText(std::string_view text);

// A floor or ceiling.
struct AirAltitude {
  enum class Kind { kAboveSea, kAboveGround, kGround, kUnlimited };
  Kind kind = Kind::kAboveSea;
  double altitude_m = 0.0;
};
// "GND", "SFC", "UNL", "FL 95", "4500 FT MSL", "1000 M AGL", "3000"; feet above mean sea level
// where nothing else is said. Nothing for any other text.
std::optional<AirAltitude> AirAltitudeFromText(std::string_view text);

}  // namespace freelsd
