// Whose turn it is to be evaluated.
#pragma once

#include <algorithm>
#include <deque>
#include <mutex>
#include <optional>
#include <string>

namespace freelsd {

// Flights in the order in which they began to wait. A flight waits at most once, so one that is due
// again and again comes behind all others. Thread-safe.
class EvaluationQueue {
 public:
  // Does nothing if the flight waits already.
  void Add(const std::string& flight_id) {
    const std::lock_guard lock(mutex_);
    const bool waits = std::find(waiting_.begin(), waiting_.end(), flight_id) != waiting_.end();
    if (!waits) waiting_.push_back(flight_id);
  }
  // The flight that waits longest; nothing if none does.
  std::optional<std::string> Take() {
    const std::lock_guard lock(mutex_);
    if (waiting_.empty()) return std::nullopt;
    std::string flight_id = std::move(waiting_.front());
    waiting_.pop_front();
    return flight_id;
  }

 private:
  // Guards waiting_.
  std::mutex mutex_;
  std::deque<std::string> waiting_;
};

}  // namespace freelsd
