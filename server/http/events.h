// A log of the latest events, numbered. Server-Sent Events are read from it.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace freelsd {

struct Event {
  int64_t number = 0;
  std::string type;  // frame, region, site, job, alternates
  std::string flight_id;
  std::string data;  // JSON, one line
};

// Thread-safe. Publish never waits for listeners; a listener that is too slow gets Batch::has_gap.
class EventLog {
 public:
  EventLog();

  void Publish(const std::string& type, const std::string& flight_id, const std::string& data);
  // Ends all calls of WaitAfter.
  void Stop();

  // "<start time of this log>-<number>"; unique also across restarts.
  std::string IdOf(int64_t number) const;
  int64_t LastNumber() const;
  // The number in an id. Nothing if another log made the id, or if later events were dropped.
  std::optional<int64_t> NumberOf(const std::string& id) const;

  struct Batch {
    std::vector<Event> events;
    // Events were dropped: the listener must fetch the whole state.
    bool has_gap = false;
    // Stop was called.
    bool is_over = false;
    int64_t last_number = 0;
  };
  // Waits for events after `number` and returns them; no events if the deadline passes first. An
  // empty flight_id stands for all flights.
  Batch WaitAfter(int64_t number,
                  const std::string& flight_id,
                  std::chrono::steady_clock::time_point deadline) const;

 private:
  std::string epoch_;
  // Guards events_, last_number_ and is_over_.
  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  std::deque<Event> events_;
  int64_t last_number_ = 0;
  bool is_over_ = false;
};

}  // namespace freelsd
