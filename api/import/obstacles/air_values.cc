#include "api/import/obstacles/air_values.h"

#include <algorithm>
#include <cctype>
#include <set>
#include <string>
#include <vector>

#include "api/import/angle_text.h"
#include "api/import/number_text.h"

namespace freelsd {
namespace {

constexpr double kMetresPerFoot = 0.3048;
constexpr double kMaxAltitudeM = 20000.0;
// Flight levels have at most three digits.
constexpr double kMaxFlightLevel = 999.0;

bool IsDigit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

std::string Upper(std::string_view text) {
  std::string upper;
  for (const char c : text) {
    upper += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  }
  return upper;
}

// Numbers and words, also where nothing stands between them: "4500FT" are two.
std::vector<std::string> AltitudeWordsOf(const std::string& text) {
  std::vector<std::string> words;
  bool was_number = false;
  for (const char c : text) {
    const bool is_number = IsDigit(c) || c == '.';
    const bool is_word = std::isalpha(static_cast<unsigned char>(c)) != 0;
    if (!is_number && !is_word) {
      was_number = false;
      if (words.empty() || !words.back().empty()) words.emplace_back();
      continue;
    }
    if (words.empty() || (!words.back().empty() && is_number != was_number)) words.emplace_back();
    words.back() += c;
    was_number = is_number;
  }
  std::erase_if(words, [](const std::string& word) { return word.empty(); });
  return words;
}

struct AltitudeWords {
  std::optional<double> number;
  double unit_m = kMetresPerFoot;
  bool is_flight_level = false;
  bool is_above_ground = false;
  bool is_ground = false;
  bool is_unlimited = false;
};

// False if the word has no meaning here.
bool Take(const std::string& word, AltitudeWords& words) {
  if (IsDigit(word.front())) {
    const bool is_first = !words.number;
    words.number = NumberFromText(word);
    return is_first && words.number;
  }
  if (word == "FL") words.unit_m = 100.0 * kMetresPerFoot;
  if (word == "M") words.unit_m = 1.0;
  words.is_flight_level |= word == "FL";
  words.is_above_ground |= word == "AGL" || word == "ASFC";
  words.is_ground |= word == "GND" || word == "SFC" || word == "GROUND" || word == "SURFACE";
  words.is_unlimited |= word.starts_with("UNL");
  static const std::set<std::string> kKnown{"FL",
                                            "M",
                                            "AGL",
                                            "ASFC",
                                            "GND",
                                            "SFC",
                                            "GROUND",
                                            "SURFACE",
                                            "FT",
                                            "F",
                                            "FEET",
                                            "MSL",
                                            "AMSL",
                                            "ALT",
                                            "STD"};
  return kKnown.contains(word) || word.starts_with("UNL");
}

}  // namespace

std::optional<GeoPoint> CoordinatesFromText(std::string_view text) {
  const std::string upper = Upper(Trimmed(text));
  // Letters stand behind both angles, or before both.
  const size_t pole = upper.find_first_of("NS");
  const size_t side = upper.find_first_of("EW");
  if (pole == std::string::npos || side == std::string::npos) return std::nullopt;
  const std::string_view both = upper;
  const size_t split = pole == 0 ? side : pole + 1;
  std::string_view second = both.substr(split);
  second.remove_prefix(std::min(second.find_first_not_of(" ,\t"), second.size()));
  const std::string_view first = both.substr(0, split);
  const auto latitude_deg =
      AngleFromText(first.substr(0, first.find_last_not_of(" ,\t") + 1), Axis::kLatitude);
  const auto longitude_deg = AngleFromText(second, Axis::kLongitude);
  if (!latitude_deg || !longitude_deg) return std::nullopt;
  return GeoPoint{*latitude_deg, *longitude_deg, 0.0};
}

std::optional<AirAltitude> AirAltitudeFromText(std::string_view text) {
  AltitudeWords words;
  for (const std::string& word : AltitudeWordsOf(Upper(text))) {
    if (!Take(word, words)) return std::nullopt;
  }
  const bool is_ground = words.is_ground || (words.is_above_ground && words.number == 0.0);
  if (!words.number && !words.is_unlimited) {
    return is_ground ? std::optional(AirAltitude{AirAltitude::Kind::kGround, 0.0}) : std::nullopt;
  }
  if (!words.number) return AirAltitude{AirAltitude::Kind::kUnlimited, 0.0};
  if (words.is_flight_level && *words.number > kMaxFlightLevel) return std::nullopt;
  const double altitude_m = *words.number * words.unit_m;
  if (altitude_m > kMaxAltitudeM) return AirAltitude{AirAltitude::Kind::kUnlimited, 0.0};
  // "1000 GND" is above ground too, and 0 is the ground.
  if (words.is_above_ground || words.is_ground) {
    return AirAltitude{
        altitude_m > 0.0 ? AirAltitude::Kind::kAboveGround : AirAltitude::Kind::kGround,
        altitude_m};
  }
  return AirAltitude{AirAltitude::Kind::kAboveSea, altitude_m};
}

}  // namespace freelsd
