// Wall-clock times and new ids for rows.
#pragma once

#include <cstdint>
#include <string>

namespace freelsd {

// Microseconds since 1970 (UTC).
int64_t NowUs();
// RFC 3339 in UTC, with whole seconds.
std::string Rfc3339(int64_t timestamp_us);
// A random id with a prefix: "f-3a91c0…".
std::string NewId(const std::string& prefix);

}  // namespace freelsd
