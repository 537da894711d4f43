// Dates as cameras and loggers write them.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace freelsd {

// "YYYY:MM:DD HH:MM:SS[.f]" (EXIF) or "YYYY-MM-DD[T ]HH:MM:SS[.f][Z|+hh:mm]", microseconds since
// 1970; without an offset UTC is assumed. Nothing for anything else.
std::optional<int64_t> TimestampFromText(std::string_view text);
// "+hh:mm" or "Z" in microseconds.
std::optional<int64_t> OffsetFromText(std::string_view text);
// Digits after the decimal point, in microseconds: "498032", "5".
std::optional<int64_t> FractionFromText(std::string_view digits);

}  // namespace freelsd
