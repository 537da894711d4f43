#include "server/intake/arrival_clock.h"

#include <algorithm>
#include <ctime>
#include <limits>
#include <tuple>
#include <utility>

#include "server/http/http.h"

namespace freelsd {
namespace {

// Samples that are stored together get different times of arrival.
constexpr int64_t kMaxAheadUs = 1000000;

// Farther apart, the aircraft's clock was never set, or the flight is a recording: arrivals count.
constexpr int64_t kMaxDelayUs = int64_t{86400} * 1000000;
// A clock without a network is seldom off by more. A flight of which nothing arrived sooner arrives
// late, at least until it has caught up.
constexpr int64_t kMaxClockErrorUs = int64_t{120} * 1000000;

// Delays of samples that come one after the other over a good link differ by less.
constexpr int64_t kMaxJitterUs = int64_t{2} * 1000000;
// A chain sets the clock if it has samples that arrived in so many different seconds.
constexpr int kMinNumSeconds = 5;
// Where none has, fewer samples than these set no clock that is far ahead.
constexpr int kMinNumAhead = 5;

// Nothing if the server's clock was never set. Of an aircraft's clock that was never set, or that
// shows another day, delays tell the order only.
std::optional<int64_t> DelayUs(const ArrivedSample& sample) {
  if (sample.arrived_at_us < kFirstPlausibleUs) return std::nullopt;
  return sample.arrived_at_us - sample.timestamp_us;
}

bool IsOfAnotherDay(int64_t delay_us) { return std::abs(delay_us) > kMaxDelayUs; }

// Samples in the order of their arrival, each with about the delay of the one before.
struct Chain {
  int64_t last_delay_us = 0;
  int64_t least_delay_us = std::numeric_limits<int64_t>::max();
  int64_t last_second = 0;
  int num_seconds = 0;
  int num_samples = 0;

  void Add(int64_t delay_us, int64_t second) {
    if (num_samples == 0 || second != last_second) ++num_seconds;
    ++num_samples;
    last_second = second;
    last_delay_us = delay_us;
    least_delay_us = std::min(least_delay_us, delay_us);
  }
  bool Lasts() const { return num_seconds >= kMinNumSeconds; }
  bool AgreesWithServer() const { return std::abs(least_delay_us) <= kMaxClockErrorUs; }
  int64_t JumpTo(int64_t delay_us) const { return std::abs(delay_us - last_delay_us); }
  // Greatest for the most evidence; of as much, for the clock that is nearest to the server's.
  auto Evidence() const { return std::tuple(num_seconds, num_samples, -std::abs(least_delay_us)); }
};

std::vector<Chain> ChainsOf(std::vector<ArrivedSample> arrivals) {
  std::sort(arrivals.begin(), arrivals.end(), [](const ArrivedSample& a, const ArrivedSample& b) {
    return a.arrived_at_us < b.arrived_at_us;
  });
  std::vector<Chain> chains;
  for (const ArrivedSample& sample : arrivals) {
    const std::optional<int64_t> delay_us = DelayUs(sample);
    if (!delay_us) continue;
    auto nearest =
        std::min_element(chains.begin(), chains.end(), [&](const auto& a, const auto& b) {
          return a.JumpTo(*delay_us) < b.JumpTo(*delay_us);
        });
    if (nearest == chains.end() || nearest->JumpTo(*delay_us) > kMaxJitterUs) {
      nearest = chains.insert(chains.end(), Chain());
    }
    nearest->Add(*delay_us, sample.arrived_at_us / 1000000);
  }
  return chains;
}

// Nothing arrives before it was taken, so of the chains that last, the soonest tells the clocks'
// difference: in the others the link was late. A chain that is much shorter than another one is of
// times that were wrong for a while. So is one that is far ahead of the server's clock, if another
// one agrees with it: no link is late by just what a clock is ahead.
std::optional<int64_t> DifferenceUs(std::vector<Chain> chains) {
  if (chains.empty()) return std::nullopt;
  const bool has_agreement = std::any_of(chains.begin(), chains.end(), [](const Chain& chain) {
    return chain.Lasts() && chain.AgreesWithServer();
  });
  if (has_agreement) {
    std::erase_if(chains,
                  [](const Chain& chain) { return chain.least_delay_us < -kMaxClockErrorUs; });
  }
  const Chain* told =
      &*std::max_element(chains.begin(), chains.end(), [](const Chain& a, const Chain& b) {
        return a.Evidence() < b.Evidence();
      });
  const int num_needed = std::max(kMinNumSeconds, told->num_seconds / 2);
  for (const Chain& chain : chains) {
    const bool is_sooner = chain.least_delay_us < told->least_delay_us;
    if (is_sooner && chain.num_seconds >= num_needed) told = &chain;
  }
  if (told->Lasts()) return told->least_delay_us;
  if (IsOfAnotherDay(told->least_delay_us)) return std::nullopt;
  const bool is_lone = told->num_samples < kMinNumAhead;
  return is_lone ? std::max(told->least_delay_us, -kMaxClockErrorUs) : told->least_delay_us;
}

// Of a clock that was not set, the soonest sample tells it where no chain lasts.
std::optional<int64_t> UnsetDifferenceUs(std::vector<ArrivedSample> arrivals) {
  std::erase_if(arrivals,
                [](const ArrivedSample& a) { return a.timestamp_us >= kFirstPlausibleUs; });
  const std::vector<Chain> chains = ChainsOf(std::move(arrivals));
  if (const std::optional<int64_t> difference_us = DifferenceUs(chains)) return difference_us;
  const auto soonest =
      std::min_element(chains.begin(), chains.end(), [](const auto& a, const auto& b) {
        return a.least_delay_us < b.least_delay_us;
      });
  return soonest == chains.end() ? std::nullopt : std::optional(soonest->least_delay_us);
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
  if (!was_clock_set || arrived_at_us > now_us + kMaxAheadUs) {
    return std::nullopt;
  }
  return std::max(0.0, static_cast<double>(now_us - arrived_at_us) * 1e-6);
}

FlightClock::FlightClock(std::vector<ArrivedSample> arrivals)
    : difference_us_(DifferenceUs(ChainsOf(arrivals))),
      unset_difference_us_(UnsetDifferenceUs(std::move(arrivals))) {}

std::optional<double> FlightClock::AgeS(const ArrivedSample& sample, int64_t now_us) const {
  const std::optional<double> since_arrival_s = freelsd::AgeS(sample.arrived_at_us, now_us);
  const std::optional<int64_t> delay_us = DelayUs(sample);
  if (!since_arrival_s || !delay_us || !difference_us_) return since_arrival_s;
  // A clock that was set is no longer where the aircraft's computer has started again.
  const bool is_unset = sample.timestamp_us < kFirstPlausibleUs;
  if (is_unset || IsOfAnotherDay(*difference_us_)) {
    // Only how much later than the others it arrived is known, unless it is of another clock.
    const int64_t later_us =
        *delay_us - (is_unset ? unset_difference_us_.value_or(*delay_us) : *difference_us_);
    if (IsOfAnotherDay(later_us)) return since_arrival_s;
    return *since_arrival_s + static_cast<double>(std::max<int64_t>(0, later_us)) * 1e-6;
  }
  if (*delay_us < std::min<int64_t>(0, *difference_us_) - kMaxJitterUs) return std::nullopt;
  const int64_t error_us = *difference_us_ > kMaxClockErrorUs ? 0 : *difference_us_;
  return *since_arrival_s + static_cast<double>(std::max<int64_t>(0, *delay_us - error_us)) * 1e-6;
}

std::optional<double> WindAgeS(const ArrivedSample& wind,
                               std::optional<double> age_s,
                               int64_t now_us) {
  const std::optional<int64_t> delay_us = DelayUs(wind);
  const bool was_clock_set = wind.timestamp_us >= kFirstPlausibleUs;
  if (!was_clock_set || !delay_us || *delay_us <= kMaxDelayUs) return age_s;
  return static_cast<double>(now_us - wind.timestamp_us) * 1e-6;
}

}  // namespace freelsd
