// Latitudes and longitudes as people and programs write them.
#pragma once

#include <optional>
#include <string_view>

namespace freelsd {

enum class Axis { kLatitude, kLongitude };

// Degrees of "47.351", "-2,76", "47 deg 21' 3.60\" N", "N 47:21.06", "2.76 W" or "47d21m3.6s". A
// longitude may be up to 360 degrees. Minutes and seconds may be 60. Nothing for any other text,
// for an angle that is not on the earth, for the letter of the other axis, and for a minus beside N
// or E.
std::optional<double> AngleFromText(std::string_view text, Axis axis);

// With the hemisphere in `reference`: "N", "south", "W ". Nothing if it has another meaning.
std::optional<double> AngleInHemisphere(double angle_deg, std::string_view reference, Axis axis);

}  // namespace freelsd
