// Numbers with units. Private to poses/.
#pragma once

#include <optional>
#include <string_view>

namespace freelsd {

enum class Quantity { kNone, kLength, kAngle, kSpeed, kTime };
// A unit, in metres, degrees, metres per second or microseconds.
struct Unit {
  Quantity quantity = Quantity::kNone;
  double factor = 1.0;
};
// Nothing for any other text. Case does not count.
std::optional<Unit> UnitFromText(std::string_view text);

// In the unit of Unit: of "12.5", "41 ft", "12,5" with a decimal comma, "1,234.5" without one, or
// "555.9 m Above Sea Level". A unit beside the number counts more than the column's. Nothing for
// any other text, a unit of another quantity, and what is not finite.
std::optional<double> MeasureFromText(std::string_view text,
                                      const std::optional<Unit>& column_unit,
                                      Quantity quantity,
                                      bool has_decimal_comma);

}  // namespace freelsd
