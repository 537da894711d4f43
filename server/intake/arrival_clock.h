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

// Ages of one flight's samples. A sample may arrive long after it was taken: a link delivers what
// it kept during an outage. The sample's own time says so, if the aircraft's clock shows about the
// server's time. A constant difference is an error of a clock, not a delay.
class FlightClock {
 public:
  // A sample of the flight; the more, the better the difference of the clocks is known.
  void Hear(int64_t timestamp_us, int64_t arrived_at_us);
  // Seconds since the sample was taken, and never less than since it arrived. Nothing: unknown.
  std::optional<double> AgeS(int64_t timestamp_us, int64_t arrived_at_us, int64_t now_us) const;

 private:
  std::optional<int64_t> least_delay_us_;
};

}  // namespace freelsd
