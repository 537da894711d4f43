// Parsing of dates that cameras and loggers write.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace freelsd {

// Reads "YYYY:MM:DD HH:MM:SS[.f]" (EXIF) or "YYYY-MM-DD[T ]HH:MM:SS[.f][Z|+hh:mm]". Microseconds
// since 1970; UTC is assumed if there is no offset. Nothing for any other text.
std::optional<int64_t> TimestampFromText(std::string_view text);
// True if the text of a date and time ends with its offset from UTC.
bool HasOffset(std::string_view text);
// Reads "+hh:mm" or "Z". Microseconds.
std::optional<int64_t> OffsetFromText(std::string_view text);
// Microseconds from the digits after the decimal point: "5" is 500000.
std::optional<int64_t> FractionFromText(std::string_view digits);

}  // namespace freelsd
