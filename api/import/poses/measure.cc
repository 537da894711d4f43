#include "api/import/poses/measure.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "api/import/number_text.h"
#include "api/import/poses/side_files.h"

namespace freelsd {
namespace {

// Commas become points, or vanish where each stands before three digits and no decimal comma is.
std::optional<std::string> WithPoint(std::string number, bool has_decimal_comma) {
  const size_t num_commas = static_cast<size_t>(std::count(number.begin(), number.end(), ','));
  if (num_commas == 0) return number;
  const size_t point = number.find('.'), last = number.rfind(',');
  const bool is_decimal = num_commas == 1 && point == std::string::npos && has_decimal_comma;
  const bool has_thousands_points = num_commas == 1 && point < last;
  if (is_decimal || has_thousands_points) {
    number[last] = ',';
    std::erase(number, '.');
    std::replace(number.begin(), number.end(), ',', '.');
    return number;
  }
  const size_t end = std::min(point, number.size());
  for (size_t i = number.find(','); i != std::string::npos; i = number.find(',', i + 1)) {
    const size_t next = std::min(number.find(',', i + 1), end);
    if (next - i != 4) return std::nullopt;
  }
  std::erase(number, ',');
  return number;
}

// Without words of the altitude's datum, which the caller reads.
std::string_view UnitText(std::string_view rest) {
  for (const char* const word :
       {"Above", "Below", "above", "below", "AMSL", "amsl", "MSL", "ASL"}) {
    rest = Trimmed(rest.substr(0, rest.find(word)));
  }
  return rest;
}

}  // namespace

std::optional<Unit> UnitFromText(std::string_view text) {
  struct NamedUnits {
    std::string_view names;
    Unit unit;
  };
  constexpr NamedUnits kUnits[] = {
      {"m metre metres meter meters", {Quantity::kLength, 1.0}},
      {"ft feet foot", {Quantity::kLength, 0.3048}},
      {"km", {Quantity::kLength, 1000.0}},
      {"cm", {Quantity::kLength, 0.01}},
      {"mm", {Quantity::kLength, 0.001}},
      {"deg degree degrees \u00b0 dd", {Quantity::kAngle, 1.0}},
      {"rad radian radians", {Quantity::kAngle, 180.0 / kPi}},
      {"gon grad", {Quantity::kAngle, 0.9}},
      {"mps m/s", {Quantity::kSpeed, 1.0}},
      {"kmh km/h kph", {Quantity::kSpeed, 1.0 / 3.6}},
      {"kt kts kn knot knots", {Quantity::kSpeed, 1852.0 / 3600.0}},
      {"mph", {Quantity::kSpeed, 0.44704}},
      {"us", {Quantity::kTime, 1.0}},
      {"ms", {Quantity::kTime, 1e3}},
      {"s sec second seconds", {Quantity::kTime, 1e6}},
  };
  const std::string lower = InLowerCase(Trimmed(text));
  for (const NamedUnits& units : kUnits) {
    const std::vector<std::string> names = WordsOf(units.names);
    if (std::find(names.begin(), names.end(), lower) != names.end()) return units.unit;
  }
  return std::nullopt;
}

std::optional<double> MeasureFromText(std::string_view text,
                                      const std::optional<Unit>& column_unit,
                                      Quantity quantity,
                                      bool has_decimal_comma) {
  text = Trimmed(text);
  size_t end = std::min(text.find_first_not_of("+-0123456789.,/"), text.size());
  // An exponent, before which "e" is no unit.
  if (end + 1 < text.size() && (text[end] == 'e' || text[end] == 'E')) {
    end = std::min(text.find_first_not_of("+-0123456789", end + 1), text.size());
  }
  const auto plain = WithPoint(std::string(text.substr(0, end)), has_decimal_comma);
  const std::optional<double> number = plain ? NumberFromText(*plain) : std::nullopt;
  if (!number) return std::nullopt;
  const std::string_view unit_text = UnitText(text.substr(end));
  const std::optional<Unit> unit = unit_text.empty() ? column_unit : UnitFromText(unit_text);
  if (unit_text.empty() && !unit) return number;
  if (!unit || (unit->quantity != quantity && !unit_text.empty())) return std::nullopt;
  const double measure = *number * unit->factor;
  return std::isfinite(measure) ? std::optional(measure) : std::nullopt;
}

}  // namespace freelsd
