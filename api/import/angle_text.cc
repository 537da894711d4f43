#include "api/import/angle_text.h"

#include <cctype>
#include <cmath>
#include <string>
#include <vector>

#include "api/import/number_text.h"

namespace freelsd {
namespace {

bool IsDecimal(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }
bool IsAsciiLetter(char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0; }

// 1 or -1; nothing if the word is no hemisphere of the axis.
std::optional<int> SignOf(const std::string& word, Axis axis) {
  const bool is_latitude = axis == Axis::kLatitude;
  if (is_latitude ? word == "n" || word == "north" : word == "e" || word == "east") return 1;
  if (is_latitude ? word == "s" || word == "south" : word == "w" || word == "west") return -1;
  return std::nullopt;
}

// The numbers, the sign and the hemisphere of a text.
struct Parts {
  std::vector<double> numbers;
  bool is_negative = false;
  std::optional<int> hemisphere;
};

class AngleReader {
 public:
  AngleReader(std::string_view text, Axis axis) : text_(text), axis_(axis) {}

  std::optional<Parts> Read() {
    while (at_ < text_.size()) {
      const char c = text_[at_];
      const bool is_ok = IsDecimal(c) || c == '.' ? TakeNumber()
                         : IsAsciiLetter(c)       ? TakeWord()
                                                  : TakeSign();
      if (!is_ok) return std::nullopt;
    }
    return parts_;
  }

 private:
  // A comma between digits is a decimal one.
  bool TakeNumber() {
    std::string number;
    bool has_mark = false;
    for (; at_ < text_.size(); ++at_) {
      const char c = text_[at_];
      const bool is_comma = c == ',' && at_ + 1 < text_.size() && IsDecimal(text_[at_ + 1]);
      const bool is_mark = c == '.' || is_comma;
      if (!IsDecimal(c) && !is_mark) break;
      if (is_mark && has_mark) return false;
      has_mark = has_mark || is_mark;
      number += is_mark ? '.' : c;
    }
    const std::optional<double> value = NumberFromText(number);
    // Only the last part has a fraction.
    if (!value || had_fraction_) return false;
    had_fraction_ = *value != std::floor(*value);
    parts_.numbers.push_back(*value);
    return true;
  }

  bool TakeWord() {
    const size_t first = at_;
    while (at_ < text_.size() && IsAsciiLetter(text_[at_])) ++at_;
    const std::string word = InLowerCase(text_.substr(first, at_ - first));
    const bool is_second = word == "s" && had_minutes_ && parts_.numbers.size() == 3;
    if (const auto sign = SignOf(word, axis_); sign && !is_second) {
      const bool is_first = !parts_.hemisphere;
      parts_.hemisphere = sign;
      return is_first;
    }
    had_minutes_ = had_minutes_ || word == "m" || word == "min";
    return is_second || word == "d" || word == "deg" || word == "degree" || word == "degrees" ||
           word == "m" || word == "min" || word == "sec";
  }

  // Blanks and the marks of degrees, minutes and seconds, in any encoding.
  bool TakeSign() {
    const char c = text_[at_++];
    if (c == '-' || c == '+') {
      parts_.is_negative = c == '-';
      return parts_.numbers.empty();
    }
    return c == ' ' || c == '\t' || c == ':' || c == '\'' || c == '"' ||
           static_cast<unsigned char>(c) >= 0x80;
  }

  std::string_view text_;
  Axis axis_;
  size_t at_ = 0;
  bool had_fraction_ = false;
  bool had_minutes_ = false;
  Parts parts_;
};

}  // namespace

std::optional<double> AngleFromText(std::string_view text, Axis axis) {
  const std::optional<Parts> parts = AngleReader(Trimmed(text), axis).Read();
  if (!parts || parts->numbers.empty() || parts->numbers.size() > 3) return std::nullopt;
  double degrees = 0.0, unit = 1.0;
  for (const double number : parts->numbers) {
    if (unit > 1.0 && number > 60.0) return std::nullopt;
    degrees += number / unit;
    unit *= 60.0;
  }
  if (parts->hemisphere == 1 && parts->is_negative) return std::nullopt;
  if (parts->is_negative || parts->hemisphere == -1) degrees = -degrees;
  if (axis == Axis::kLatitude) {
    return std::abs(degrees) <= 90.0 ? std::optional(degrees) : std::nullopt;
  }
  if (degrees < -180.0 || degrees > 360.0) return std::nullopt;
  return degrees > 180.0 ? degrees - 360.0 : degrees;
}

std::optional<double> AngleInHemisphere(double angle_deg, std::string_view reference, Axis axis) {
  const std::optional<int> sign = SignOf(InLowerCase(Trimmed(reference)), axis);
  if (!sign || (*sign == 1 && angle_deg < 0.0)) return std::nullopt;
  return *sign * std::abs(angle_deg);
}

}  // namespace freelsd
