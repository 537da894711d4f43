// What happened lately, numbered, for those who listen: Server-Sent Events are read from here.
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

// Thread-safe. Never waits for a listener: who is too slow is told so.
class EventLog {
 public:
  EventLog();

  void Publish(const std::string& type, const std::string& flight_id, const std::string& data);
  // Ends all waiting.
  void Stop();

  // "<start of this log>-<number>", unique beyond a restart.
  std::string IdOf(int64_t number) const;
  // The number of the last event; of an id of this log, the number in it; nothing where events
  // after it are not kept any more, or it is of another log.
  int64_t LastNumber() const;
  std::optional<int64_t> NumberOf(const std::string& id) const;

  struct Batch {
    std::vector<Event> events;
    // Events were lost: the listener must ask for the whole state.
    bool has_gap = false;
    bool is_over = false;
    int64_t last_number = 0;
  };
  // Events after `number`, of one flight or all (empty), as soon as there is one; none at the
  // deadline.
  Batch WaitAfter(int64_t number,
                  const std::string& flight_id,
                  std::chrono::steady_clock::time_point deadline) const;

 private:
  std::string epoch_;
  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  std::deque<Event> events_;
  int64_t last_number_ = 0;
  bool is_over_ = false;
};

}  // namespace freelsd
