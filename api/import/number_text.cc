#include "api/import/number_text.h"

#include <charconv>
#include <cmath>

namespace freelsd {
namespace {

std::optional<double> FiniteNumber(std::string_view text) {
  if (!text.empty() && text[0] == '+') text.remove_prefix(1);
  double number = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(number)) {
    return std::nullopt;
  }
  return number;
}

}  // namespace

std::string_view Trimmed(std::string_view text) {
  const size_t first = text.find_first_not_of(" \t\r\n");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r\n") - first + 1);
}

std::string InLowerCase(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return lower;
}

std::optional<double> NumberFromText(std::string_view text) {
  text = Trimmed(text);
  const size_t slash = text.find('/');
  if (slash == std::string_view::npos) return FiniteNumber(text);
  const std::optional<double> numerator = FiniteNumber(text.substr(0, slash));
  const std::optional<double> denominator = FiniteNumber(text.substr(slash + 1));
  if (!numerator || !denominator || *denominator == 0.0) return std::nullopt;
  return *numerator / *denominator;
}

}  // namespace freelsd
