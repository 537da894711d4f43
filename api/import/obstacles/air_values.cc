#include "api/import/obstacles/air_values.h"

#include <cctype>
#include <set>
#include <string>
#include <vector>

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

// "47:35:24", "47:35.4" or "47.59" in degrees.
std::optional<double> DegreesFromText(std::string_view text) {
  double degrees = 0.0, unit = 1.0;
  for (int part = 0; part < 3; ++part) {
    const size_t colon = text.find(':');
    const std::string_view digits = Trimmed(text.substr(0, colon));
    if (digits.empty() || !IsDigit(digits.front())) return std::nullopt;
    const std::optional<double> number = NumberFromText(digits);
    if (!number || *number < 0.0 || (part > 0 && *number >= 60.0)) return std::nullopt;
    degrees += *number / unit;
    unit *= 60.0;
    if (colon == std::string_view::npos) return degrees;
    text.remove_prefix(colon + 1);
  }
  return std::nullopt;
}

struct Hemisphere {
  char positive;
  char negative;
  double max_deg;
};

// Removes one angle and its letter from the beginning of the text.
std::optional<double> TakeAngle(std::string_view& text, const Hemisphere& hemisphere) {
  size_t at = 0;
  while (at < text.size() && text[at] != hemisphere.positive && text[at] != hemisphere.negative) {
    ++at;
  }
  if (at == text.size()) return std::nullopt;
  const std::optional<double> degrees = DegreesFromText(Trimmed(text.substr(0, at)));
  const bool is_negative = text[at] == hemisphere.negative;
  text.remove_prefix(at + 1);
  if (!degrees || *degrees > hemisphere.max_deg) return std::nullopt;
  return is_negative ? -*degrees : *degrees;
}

// Numbers and words, also where nothing stands between them: "4500FT" are two.
std::vector<std::string> WordsOf(const std::string& text) {
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
  // The ground, or unlimited.
  bool is_limit = false;
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
  words.is_limit |= word == "GND" || word == "SFC" || word.starts_with("UNL");
  static const std::set<std::string> kKnown{
      "FL", "M", "AGL", "ASFC", "GND", "SFC", "FT", "F", "MSL", "AMSL", "ALT", "STD"};
  return kKnown.contains(word) || word.starts_with("UNL");
}

}  // namespace

std::optional<GeoPoint> CoordinatesFromText(std::string_view text) {
  const std::string upper = Upper(text);
  std::string_view rest = upper;
  const std::optional<double> latitude_deg = TakeAngle(rest, {'N', 'S', 90.0});
  if (!latitude_deg) return std::nullopt;
  while (!rest.empty() && (rest.front() == ' ' || rest.front() == ',')) rest.remove_prefix(1);
  const std::optional<double> longitude_deg = TakeAngle(rest, {'E', 'W', 180.0});
  if (!longitude_deg || !Trimmed(rest).empty()) return std::nullopt;
  return GeoPoint{*latitude_deg, *longitude_deg, 0.0};
}

std::optional<AirAltitude> AirAltitudeFromText(std::string_view text) {
  AltitudeWords words;
  for (const std::string& word : WordsOf(Upper(text))) {
    if (!Take(word, words)) return std::nullopt;
  }
  if (!words.number) return words.is_limit ? std::optional(AirAltitude{}) : std::nullopt;
  if (words.is_flight_level && *words.number > kMaxFlightLevel) return std::nullopt;
  // "1000 GND" is above ground too.
  if (words.is_above_ground || words.is_limit) return AirAltitude{{}, *words.number > 0.0};
  const double altitude_m = *words.number * words.unit_m;
  if (altitude_m > kMaxAltitudeM) return AirAltitude{};
  return AirAltitude{altitude_m, false};
}

}  // namespace freelsd
