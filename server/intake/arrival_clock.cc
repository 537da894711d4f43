#include "server/intake/arrival_clock.h"

#include <algorithm>
#include <ctime>

#include "server/http/http.h"

namespace freelsd {
namespace {

// Samples that are stored together get different times of arrival.
constexpr int64_t kMaxAheadUs = 1000000;

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

}  // namespace freelsd
