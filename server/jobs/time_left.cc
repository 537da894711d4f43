#include "server/jobs/time_left.h"

#include <algorithm>
#include <cmath>

namespace freelsd {
namespace {

// Less progress, or less time, says nothing about the speed yet.
constexpr double kMinRatio = 0.03;
constexpr double kMinTimeS = 1.0;
// Share of the progress over which the recent speed is averaged, and over which measurements
// replace the expectation.
constexpr double kMemoryRatio = 0.2;
// The estimate approaches a measurement over this time, or over a share of the measurement.
constexpr double kMinSmoothingS = 2.0;
constexpr double kSmoothingShare = 0.1;
// Work that takes longer than expected is expected to take another share of it.
constexpr double kMinExpectedShare = 0.1;
// The same for a step.
constexpr double kMinLeftShare = 0.2;

}  // namespace

void TimeLeft::Add(double time_s, double done_ratio) {
  const double growth = std::min(done_ratio, 1.0) - ratio_;
  if (!(growth > 0.0)) return;
  const double s_per_ratio = std::max(time_s - grew_at_s_, 0.0) / growth;
  const double done = ratio_ + growth - begin_ratio_;
  // The mean of all at first, then of the latest.
  const double weight =
      (1.0 - std::exp(-growth / kMemoryRatio)) / (1.0 - std::exp(-done / kMemoryRatio));
  const double before = recent_s_per_ratio_.value_or(0.0);
  recent_s_per_ratio_ = before + weight * (s_per_ratio - before);
  ratio_ += growth;
  last_step_s_ = std::max(time_s - grew_at_s_, 0.0);
  grew_at_s_ = time_s;
}

std::optional<double> TimeLeft::Measured(double time_s) const {
  const double done = ratio_ - begin_ratio_;
  const double elapsed_s = std::max(time_s - begin_s_, 0.0);
  std::optional<double> expected_left_s;
  if (expected_s_) {
    expected_left_s = std::max(*expected_s_ - elapsed_s, kMinExpectedShare * *expected_s_);
  }
  if (done < kMinRatio || elapsed_s < kMinTimeS) return expected_left_s;
  // What of the step that runs is not in the progress yet. A step that lasts longer than the last
  // one makes the mean grow.
  const double open_s = std::clamp(time_s - grew_at_s_, 0.0, last_step_s_);
  const double mean = (elapsed_s - open_s) / done;
  const double whole_s = (1.0 - ratio_) * 0.5 * (mean + recent_s_per_ratio_.value_or(mean));
  const double measured_s = std::max(whole_s - open_s, kMinLeftShare * whole_s);
  if (!expected_left_s) return measured_s;
  const double trust = std::min(done / kMemoryRatio, 1.0);
  return trust * measured_s + (1.0 - trust) * *expected_left_s;
}

std::optional<double> TimeLeft::At(double time_s) {
  const std::optional<double> measured_s = Measured(time_s);
  if (!measured_s) return std::nullopt;
  const double passed_s = std::max(time_s - smoothed_at_s_, 0.0);
  smoothed_at_s_ = std::max(time_s, smoothed_at_s_);
  if (smoothed_s_) {
    const double counted_down_s = std::max(*smoothed_s_ - passed_s, 0.0);
    const double smoothing_s = std::max(kMinSmoothingS, kSmoothingShare * *measured_s);
    const double weight = 1.0 - std::exp(-passed_s / smoothing_s);
    smoothed_s_ = counted_down_s + weight * (*measured_s - counted_down_s);
  } else {
    smoothed_s_ = *measured_s;
  }
  smoothed_s_ = std::clamp(*smoothed_s_, 0.5 * *measured_s, 2.0 * *measured_s);
  return smoothed_s_;
}

}  // namespace freelsd
