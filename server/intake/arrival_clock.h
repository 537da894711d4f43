// Times at which telemetry and frames arrive, and how old they are.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

namespace freelsd {

// 2020-01-01, microseconds since 1970. A clock with an earlier time was never set.
constexpr int64_t kFirstPlausibleUs = 1577836800000000;

// Microseconds since 1970. The first call reads the wall clock. From then on, the time comes from a
// monotonic clock that also runs while the machine sleeps. Ages therefore stay correct if the wall
// clock is set.
int64_t ArrivalNowUs();

// Seconds since the arrival. Nothing if the time of arrival is unknown: the server's clock was not
// set at that time, or it was set back since.
std::optional<double> AgeS(int64_t arrived_at_us, int64_t now_us);

struct ArrivedSample {
  // By the aircraft's clock.
  int64_t timestamp_us = 0;
  int64_t arrived_at_us = 0;
};

// Ages of one flight's samples. A sample may arrive long after it was taken: a link delivers what
// it kept during an outage. The sample's own time says so, if the aircraft's clock shows about the
// server's time. A constant difference is an error of a clock, not a delay. Of a clock that was
// never set, or that shows another day, only the order of samples is known, and how far apart they
// are.
class FlightClock {
 public:
  // `arrivals`: samples of the flight that arrived lately, in any order. Samples whose delays
  // follow each other without a jump form a chain, and only a chain that lasts sets the clock. A
  // few times ahead of all others therefore make no other sample old, and a clock that was set
  // during the flight counts once it has been consistent for some seconds.
  explicit FlightClock(std::vector<ArrivedSample> arrivals);
  // Seconds since the sample was taken, and never less than since it arrived. Nothing: unknown,
  // also for a time that is ahead of the server's clock by more than the clocks differ.
  std::optional<double> AgeS(const ArrivedSample& sample, int64_t now_us) const;

 private:
  // Arrival minus own time of the samples that arrive soonest. Nothing: too few samples tell it.
  std::optional<int64_t> difference_us_;
  // The same of samples whose clock was not set.
  std::optional<int64_t> unset_difference_us_;
};

// A wind of another day does not blow now, even if it arrives now: it is as old as its own time
// says. Otherwise `age_s`.
std::optional<double> WindAgeS(const ArrivedSample& wind,
                               std::optional<double> age_s,
                               int64_t now_us);

}  // namespace freelsd
