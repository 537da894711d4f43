#include "server/recall/altitude_datum.h"

#include <cmath>

#include "engine/glide/glide.h"
#include "server/recall/geoid/geoid.h"

namespace freelsd {
namespace {

constexpr std::string_view kUnknown = "unknown";
constexpr std::string_view kEllipsoid = "ellipsoid";

}  // namespace

DatumDifference DatumDifferenceOf(const AltitudeReference& given, const AltitudeReference& stored) {
  const bool is_one_flight = !given.flight_id.empty() && given.flight_id == stored.flight_id;
  if (given.datum == stored.datum && (given.datum != kUnknown || is_one_flight)) return {};
  const bool is_given_ellipsoidal = given.datum == kEllipsoid;
  // The geoid's height is taken at the place where the ellipsoidal altitude was measured.
  const AltitudeReference& place = is_given_ellipsoidal ? given : stored;
  const auto height_m = Egm96().HeightAt(place.latitude_deg, place.longitude_deg);
  if (!height_m) return {GlideOptions{}.datum_penalty_m, DatumBasis::kNoGeoid};
  if (given.datum == kUnknown || stored.datum == kUnknown) {
    return {std::abs(*height_m), DatumBasis::kUnknown};
  }
  return {is_given_ellipsoidal ? *height_m : -*height_m, DatumBasis::kGeoid};
}

}  // namespace freelsd
