#include "tests/server/recall/bad_clock.h"

#include <algorithm>
#include <random>

namespace freelsd {
namespace {

constexpr int64_t kSecondUs = 1000000;

int64_t SecondsUs(double seconds) { return static_cast<int64_t>(seconds * kSecondUs); }

class BadClock {
 public:
  BadClock(ClockFault fault, int num_seconds, int64_t begin_us, uint32_t seed)
      : fault_(fault), num_seconds_(num_seconds), begin_us_(begin_us), random_(seed) {
    if (fault == ClockFault::kConstant) error_us_ = SecondsUs(Between(-3600.0, 110.0));
  }

  void Fly(int second) {
    const bool is_middle = second == num_seconds_ / 2;
    if (fault_ == ClockFault::kStep && is_middle) error_us_ = SecondsUs(Between(-110.0, 110.0));
    if (fault_ == ClockFault::kBurst && is_middle) AddOutliers(second, 20);
    if (fault_ == ClockFault::kFirstIsOutlier && second == 0) return AddOutliers(second, 1);
    if (fault_ == ClockFault::kOutliers && Between(0.0, 1.0) < 0.1) AddOutliers(second, 1);
    Add(second, error_us_, false);
  }
  std::vector<TimedSample> Samples() {
    std::stable_sort(samples_.begin(), samples_.end(), [](const auto& a, const auto& b) {
      return a.arrived_at_us < b.arrived_at_us;
    });
    return std::move(samples_);
  }

 private:
  double Between(double least, double most) {
    return std::uniform_real_distribution<double>(least, most)(random_);
  }
  // Samples of an outage arrive at its end, fifty a second.
  int64_t ArrivalUs(int second, int64_t taken_at_us) {
    const int begin = num_seconds_ / 2, end = begin + num_seconds_ / 4;
    if (fault_ != ClockFault::kOutage || second < begin || second >= end) {
      return taken_at_us + SecondsUs(Between(0.05, 0.5));
    }
    return begin_us_ + end * kSecondUs + (second - begin) * kSecondUs / 50;
  }
  // error_us: how much the aircraft's clock is behind.
  void Add(int second, int64_t error_us, bool is_outlier) {
    const int64_t taken_at_us = begin_us_ + second * kSecondUs;
    samples_.push_back(
        {taken_at_us, ArrivalUs(second, taken_at_us), taken_at_us - error_us, is_outlier});
  }
  void AddOutliers(int second, int num) {
    const double ahead_s[] = {100.0, 3600.0, 12.0 * 3600.0, 86390.0};
    const int64_t error_us = -SecondsUs(ahead_s[static_cast<size_t>(Between(0.0, 3.999))]);
    for (int i = 0; i < num; ++i) Add(second, error_us - i * 50000, true);
  }

  ClockFault fault_;
  int num_seconds_;
  int64_t begin_us_;
  std::mt19937 random_;
  int64_t error_us_ = 0;
  std::vector<TimedSample> samples_;
};

}  // namespace

std::vector<TimedSample> SamplesOf(ClockFault fault,
                                   int num_seconds,
                                   int64_t begin_us,
                                   uint32_t seed) {
  BadClock clock(fault, num_seconds, begin_us, seed);
  for (int second = 0; second < num_seconds; ++second) clock.Fly(second);
  return clock.Samples();
}

}  // namespace freelsd
