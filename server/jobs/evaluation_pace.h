// When a flight's best regions are evaluated again.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>

namespace freelsd {

// Every backend_period_frames processed frames. Where a finish waits, it will evaluate everything:
// until then only the first site is worth the time, and looking for it less and less often.
class EvaluationPace {
 public:
  void AddFrame() { ++num_since_; }
  // Whether IsDue may hold, so that its other arguments must be looked up.
  bool IsPeriodOver(int period_frames) const { return num_since_ >= period_frames; }
  void BeginEvaluation() { num_before_ += std::exchange(num_since_, 0); }
  // `num_to_finish`: frames until a waiting finish can begin; nothing if none waits.
  bool IsDue(int period_frames, std::optional<int64_t> num_to_finish, bool has_site) const {
    if (!IsPeriodOver(period_frames)) return false;
    if (!num_to_finish) return true;
    return *num_to_finish >= period_frames && num_since_ >= num_before_ && !has_site;
  }

 private:
  // Frames since the last evaluation, and before it.
  int num_since_ = 0;
  int num_before_ = 0;
};

}  // namespace freelsd
