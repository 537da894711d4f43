// Estimates how long work still takes, from its measured speed.
#pragma once

#include <optional>

namespace freelsd {

// Work whose progress grows from 0 to 1. Times are seconds on any clock that never goes back.
//
// The estimate is (1 - progress) times the measured time per progress: half of it is the mean since
// the work began, half the mean of about the last fifth of the progress. Work in steps is assumed
// to proceed within a step for as long as the last one took. The estimate is smoothed: between two
// measurements it counts down with the clock, and it approaches new measurements over a few
// seconds. It is never negative, and while the work is not done never less than half nor more than
// twice of what was measured.
class TimeLeft {
 public:
  // `expected_s`: how long such work took earlier. It is the estimate until there are measurements,
  // which replace it over the first fifth of the progress. `done_ratio`: the progress at begin_s.
  TimeLeft(double begin_s, double done_ratio, std::optional<double> expected_s = std::nullopt)
      : expected_s_(expected_s),
        begin_s_(begin_s),
        begin_ratio_(done_ratio),
        grew_at_s_(begin_s),
        ratio_(done_ratio),
        smoothed_at_s_(begin_s) {}

  // Takes a measurement. Progress that does not grow changes nothing.
  void Add(double time_s, double done_ratio);
  // The estimate in seconds. Nothing until enough progress was measured.
  std::optional<double> At(double time_s);

 private:
  std::optional<double> Measured(double time_s) const;

  std::optional<double> expected_s_;
  double begin_s_;
  double begin_ratio_;
  double grew_at_s_;
  // Time between the last two growths: of work in steps, the duration of a step.
  double last_step_s_ = 0.0;
  double ratio_;
  // Of the last fifth of the progress; nothing before the first growth.
  std::optional<double> recent_s_per_ratio_;
  // What At last answered, and when.
  std::optional<double> smoothed_s_;
  double smoothed_at_s_;
};

}  // namespace freelsd
