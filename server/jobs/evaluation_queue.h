// The flights that wait for the backend.
#pragma once

#include <algorithm>
#include <deque>
#include <mutex>
#include <optional>
#include <string>

namespace freelsd {

// Flights in the order in which they began to wait. A flight is in the queue at most once, so that
// a flight with much work does not delay the others. Thread-safe.
class EvaluationQueue {
 public:
  // Does nothing if the flight waits already.
  void Add(const std::string& flight_id) {
    const std::lock_guard lock(mutex_);
    const bool waits = std::find(waiting_.begin(), waiting_.end(), flight_id) != waiting_.end();
    if (!waits) waiting_.push_back(flight_id);
  }
  // Removes and returns the flight that waits longest; nothing if no flight waits.
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
