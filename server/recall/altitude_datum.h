// The difference of two altitudes whose datums may differ or be unknown. Private to recall.
#pragma once

#include <string_view>

namespace freelsd {

// An altitude's datum, "amsl", "ellipsoid" or "unknown", its place, and the flight that measured it
// (empty: none is known). The texts must outlive it.
struct AltitudeReference {
  std::string_view datum;
  double latitude_deg = 0.0;
  double longitude_deg = 0.0;
  std::string_view flight_id;
};

// What a difference of datums was computed from.
enum class DatumBasis {
  kSame,     // one datum: nothing is subtracted
  kGeoid,    // two known datums: the geoid's height, exactly
  kUnknown,  // a datum is unknown: the geoid's height as a penalty
  kNoGeoid,  // the geoid is not installed: its greatest height as a penalty
};

// What to subtract from an altitude before it is compared with a stored one.
struct DatumDifference {
  // Negative if the altitude gains: above mean sea level, over a stored altitude above an ellipsoid
  // that lies below the sea there.
  double subtracted_m = 0.0;
  DatumBasis basis = DatumBasis::kSame;
};

// Unknown datums of one flight are the same datum.
DatumDifference DatumDifferenceOf(const AltitudeReference& given, const AltitudeReference& stored);

}  // namespace freelsd
