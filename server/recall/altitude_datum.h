// The difference of two altitudes whose datums may differ or be unknown. Private to recall.
#pragma once

#include <string_view>

namespace freelsd {

// Datum of an altitude ("amsl", "ellipsoid" or "unknown"), its place, and the id of the flight that
// measured it (empty if unknown). The texts must outlive this object.
struct AltitudeReference {
  std::string_view datum;
  double latitude_deg = 0.0;
  double longitude_deg = 0.0;
  std::string_view flight_id;
};

// How the difference of two datums is computed.
enum class DatumBasis {
  kSame,     // equal datums: nothing is subtracted
  kGeoid,    // two known datums: the geoid's height
  kUnknown,  // a datum is unknown: the geoid's height as a penalty
  kNoGeoid,  // the geoid's grid is not installed: its greatest height as a penalty
};

// What to subtract from an altitude before it is compared with a stored one.
struct DatumDifference {
  // Negative if the altitude must be increased. Example: the given altitude is above mean sea
  // level, the stored one is above the ellipsoid, and the geoid lies above the ellipsoid there.
  double subtracted_m = 0.0;
  DatumBasis basis = DatumBasis::kSame;
};

// Two unknown datums are equal if one flight measured both altitudes.
DatumDifference DatumDifferenceOf(const AltitudeReference& given, const AltitudeReference& stored);

}  // namespace freelsd
