// Wall-clock times and fresh ids for rows.
#pragma once

#include <cstdint>
#include <string>

namespace freelsd {

int64_t NowUs();
// RFC 3339, UTC, seconds.
std::string Rfc3339(int64_t timestamp_us);
// "f-3a91c0…": never the same twice.
std::string NewId(const std::string& prefix);

}  // namespace freelsd
