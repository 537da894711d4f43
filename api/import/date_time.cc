#include "api/import/date_time.h"

#include <algorithm>
#include <chrono>
#include <string>

namespace freelsd {
namespace {

constexpr int64_t kMicrosecondsPerSecond = 1000000;
constexpr size_t kDateTimeLength = 19;  // YYYY:MM:DD HH:MM:SS

bool IsDigit(char c) { return c >= '0' && c <= '9'; }

// Digits [at, at + count) as a number; -1 is not possible for digits, so nothing means "no digits".
std::optional<int> Digits(std::string_view text, size_t at, size_t count) {
  if (at + count > text.size()) return std::nullopt;
  int number = 0;
  for (size_t i = at; i < at + count; ++i) {
    if (!IsDigit(text[i])) return std::nullopt;
    number = 10 * number + (text[i] - '0');
  }
  return number;
}

std::optional<int64_t> SecondsOfDay(std::string_view text) {
  const std::optional<int> hour = Digits(text, 0, 2), minute = Digits(text, 3, 2),
                           second = Digits(text, 6, 2);
  if (!hour || !minute || !second || text[2] != ':' || text[5] != ':') return std::nullopt;
  if (*hour > 23 || *minute > 59 || *second > 60) return std::nullopt;
  return (*hour * 60 + *minute) * 60 + *second;
}

std::optional<int64_t> DaysSince1970(std::string_view text) {
  const std::optional<int> year = Digits(text, 0, 4), month = Digits(text, 5, 2),
                           day = Digits(text, 8, 2);
  if (!year || !month || !day || text[4] != text[7]) return std::nullopt;
  if (text[4] != ':' && text[4] != '-' && text[4] != '/') return std::nullopt;
  const std::chrono::year_month_day date{std::chrono::year(*year),
                                         std::chrono::month(static_cast<unsigned>(*month)),
                                         std::chrono::day(static_cast<unsigned>(*day))};
  if (!date.ok()) return std::nullopt;
  return std::chrono::sys_days(date).time_since_epoch().count();
}

}  // namespace

std::optional<int64_t> FractionFromText(std::string_view digits) {
  while (!digits.empty() && digits.back() == ' ') digits.remove_suffix(1);
  if (digits.empty() || !std::all_of(digits.begin(), digits.end(), IsDigit)) return std::nullopt;
  std::string six(digits.substr(0, 6));
  six.resize(6, '0');
  return Digits(six, 0, 6);
}

std::optional<int64_t> OffsetFromText(std::string_view text) {
  if (text == "Z") return 0;
  if (text.size() != 6 || (text[0] != '+' && text[0] != '-') || text[3] != ':') return std::nullopt;
  const std::optional<int> hours = Digits(text, 1, 2), minutes = Digits(text, 4, 2);
  if (!hours || !minutes || *hours > 14 || *minutes > 59) return std::nullopt;
  const int64_t seconds = (*hours * 60 + *minutes) * int64_t{60};
  return (text[0] == '-' ? -seconds : seconds) * kMicrosecondsPerSecond;
}

bool HasOffset(std::string_view text) {
  if (text.size() <= kDateTimeLength) return false;
  return text.back() == 'Z' || OffsetFromText(text.substr(text.size() - 6));
}

std::optional<int64_t> TimestampFromText(std::string_view text) {
  if (text.size() < kDateTimeLength || (text[10] != ' ' && text[10] != 'T')) return std::nullopt;
  const std::optional<int64_t> days = DaysSince1970(text.substr(0, 10));
  const std::optional<int64_t> seconds = SecondsOfDay(text.substr(11, 8));
  if (!days || !seconds) return std::nullopt;
  std::string_view rest = text.substr(kDateTimeLength);
  int64_t fraction = 0;
  if (!rest.empty() && rest[0] == '.') {
    size_t end = 1;
    while (end < rest.size() && IsDigit(rest[end])) ++end;
    const std::optional<int64_t> read = FractionFromText(rest.substr(1, end - 1));
    if (!read) return std::nullopt;
    fraction = *read;
    rest.remove_prefix(end);
  }
  const std::optional<int64_t> offset = rest.empty() ? 0 : OffsetFromText(rest);
  if (!offset) return std::nullopt;
  return (*days * 86400 + *seconds) * kMicrosecondsPerSecond + fraction - *offset;
}

}  // namespace freelsd
