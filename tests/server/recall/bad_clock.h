// Samples of an aircraft whose clock, or whose link, is at fault, with the truth about each.
#pragma once

#include <cstdint>
#include <vector>

namespace freelsd {

enum class ClockFault {
  kNone,
  // Minutes off, always the same.
  kConstant,
  // Now and then one sample is ahead, from 100 s to a day.
  kOutliers,
  // Only the first sample is ahead.
  kFirstIsOutlier,
  // Twenty samples ahead that arrive together.
  kBurst,
  // In the middle of the flight the clock is set, by up to two minutes to either side.
  kStep,
  // In the middle of the flight the link is silent, and then delivers what it kept, oldest first.
  kOutage,
};

struct TimedSample {
  // By the server's clock.
  int64_t taken_at_us = 0;
  int64_t arrived_at_us = 0;
  // By the aircraft's clock.
  int64_t timestamp_us = 0;
  // Its time is wrong, and so may be what it measured.
  bool is_outlier = false;
};

// One good sample a second from begin_us on, in the order of arrival. The same seed gives the same.
std::vector<TimedSample> SamplesOf(ClockFault fault,
                                   int num_seconds,
                                   int64_t begin_us,
                                   uint32_t seed);

}  // namespace freelsd
