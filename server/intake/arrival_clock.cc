#include "server/intake/arrival_clock.h"

#include <algorithm>
#include <ctime>

#include "server/http/http.h"

namespace freelsd {
namespace {

// Samples that are stored together get different times of arrival.
constexpr int64_t kMaxAheadUs = 1000000;

// Farther apart, the aircraft's clock was never set, or the flight is a recording.
constexpr int64_t kMaxDelayUs = int64_t{86400} * 1000000;
// A clock without a network is seldom off by more. A flight of which nothing arrived sooner arrives
// late, at least until it has caught up.
constexpr int64_t kMaxClockErrorUs = int64_t{120} * 1000000;

// Nothing if the two times cannot be compared.
std::optional<int64_t> DelayUs(int64_t timestamp_us, int64_t arrived_at_us) {
  if (arrived_at_us < kFirstPlausibleUs || timestamp_us < kFirstPlausibleUs) return std::nullopt;
  const int64_t delay_us = arrived_at_us - timestamp_us;
  if (delay_us > kMaxDelayUs || delay_us < -kMaxDelayUs) return std::nullopt;
  return delay_us;
}

int64_t SinceBootUs() {
  timespec now{};
  ::clock_gettime(CLOCK_BOOTTIME, &now);
  return int64_t{now.tv_sec} * 1000000 + now.tv_nsec / 1000;
}

}  // namespace

int64_t ArrivalNowUs() {
  static const int64_t kBootedAtUs = NowUs() - SinceBootUs();
  return kBootedAtUs + SinceBootUs();
}

std::optional<double> AgeS(int64_t arrived_at_us, int64_t now_us) {
  const bool was_clock_set = arrived_at_us >= kFirstPlausibleUs || now_us < kFirstPlausibleUs;
  if (arrived_at_us <= 0 || !was_clock_set || arrived_at_us > now_us + kMaxAheadUs) {
    return std::nullopt;
  }
  return std::max(0.0, static_cast<double>(now_us - arrived_at_us) * 1e-6);
}

void FlightClock::Hear(int64_t timestamp_us, int64_t arrived_at_us) {
  const std::optional<int64_t> delay_us = DelayUs(timestamp_us, arrived_at_us);
  if (!delay_us) return;
  least_delay_us_ = std::min(least_delay_us_.value_or(*delay_us), *delay_us);
}

std::optional<double> FlightClock::AgeS(int64_t timestamp_us,
                                        int64_t arrived_at_us,
                                        int64_t now_us) const {
  const std::optional<double> since_arrival_s = freelsd::AgeS(arrived_at_us, now_us);
  const std::optional<int64_t> delay_us = DelayUs(timestamp_us, arrived_at_us);
  if (!since_arrival_s || !delay_us) return since_arrival_s;
  const int64_t least_us = least_delay_us_.value_or(0);
  const int64_t error_us = least_us > kMaxClockErrorUs ? 0 : least_us;
  return *since_arrival_s + static_cast<double>(std::max<int64_t>(0, *delay_us - error_us)) * 1e-6;
}

}  // namespace freelsd
