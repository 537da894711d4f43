// Times at which telemetry and frames arrive, and how old they are.
#pragma once

#include <cstdint>
#include <optional>

namespace freelsd {

// 2020-01-01, microseconds since 1970. A clock with an earlier time was never set.
constexpr int64_t kFirstPlausibleUs = 1577836800000000;

// Microseconds since 1970. The first call reads the wall clock. From then on, the time comes from a
// monotonic clock that also runs while the machine sleeps. Ages therefore stay correct if the wall
// clock is set.
int64_t ArrivalNowUs();

// Seconds since the arrival. Nothing if the time of arrival is unknown. Reasons: an older version
// stored the row, the server's clock was not set at that time, or it was set back since.
std::optional<double> AgeS(int64_t arrived_at_us, int64_t now_us);

}  // namespace freelsd
