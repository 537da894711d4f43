#include "api/import/obstacles/air_values.h"

#include <cctype>
#include <string>
#include <vector>

#include "api/import/number_text.h"

namespace freelsd {
namespace {

constexpr double kMetresPerFoot = 0.3048;
constexpr double kMaxAltitudeM = 20000.0;

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
  std::optional<double> number;
  double unit_m = kMetresPerFoot;
  AirAltitude altitude;
  bool is_limit = false;
  for (const std::string& word : WordsOf(Upper(text))) {
    if (IsDigit(word.front())) {
      if (number) return std::nullopt;
      number = NumberFromText(word);
      if (!number) return std::nullopt;
    } else if (word == "FL") {
      unit_m = 100.0 * kMetresPerFoot;
    } else if (word == "M") {
      unit_m = 1.0;
    } else if (word == "AGL" || word == "ASFC") {
      altitude.is_above_ground = true;
    } else if (word == "GND" || word == "SFC" || word.starts_with("UNL")) {
      is_limit = true;
    } else if (word != "FT" && word != "F" && word != "MSL" && word != "AMSL" && word != "ALT" &&
               word != "STD") {
      return std::nullopt;
    }
  }
  if (is_limit && number && !altitude.is_above_ground) {
    // "1000 GND": above ground.
    altitude.is_above_ground = true;
  }
  if (!number && !is_limit) return std::nullopt;
  if (number && *number == 0.0 && altitude.is_above_ground) return AirAltitude{};
  if (number && !altitude.is_above_ground) {
    altitude.altitude_m = *number * unit_m;
    if (*altitude.altitude_m > kMaxAltitudeM) altitude.altitude_m.reset();
  }
  return altitude;
}

}  // namespace freelsd
