// Times at which telemetry and frames arrive, and how old they are.
#pragma once

#include <cstdint>
#include <optional>

namespace freelsd {

// A clock that says less was never set: 2020-01-01, microseconds since 1970.
constexpr int64_t kFirstPlausibleUs = 1577836800000000;

// Microseconds since 1970 by the wall clock at the first call, and from then on by a clock that
// nobody can set and that runs while the machine sleeps: ages stay right if the wall clock is set.
int64_t ArrivalNowUs();

// Seconds since the arrival. Nothing if the time of arrival is unknown: an older version stored the
// row, or the server's clock was not set then, or it was set back since.
std::optional<double> AgeS(int64_t arrived_at_us, int64_t now_us);

}  // namespace freelsd
