// Numbered log of the latest events, the source of Server-Sent Events.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace freelsd {

struct Event {
  int64_t number = 0;
  std::string type;  // frame, region, site, job, alternates, link, resync
  std::string flight_id;
  std::string data;  // JSON, one line
};

// Thread-safe. Publish never waits for listeners. A listener that is too slow gets Batch::has_gap.
class EventLog {
 public:
  EventLog();

  // If `data` is larger than kLimits.events.max_event_bytes, publishes an event "resync" instead.
  // The client must then fetch the state.
  void Publish(const std::string& type, const std::string& flight_id, const std::string& data);
  // The same for an event that another server published.
  void Relay(const std::string& type, const std::string& flight_id, const std::string& data);
  // `tell` is called with each event of Publish, by the thread that publishes. It must not wait. To
  // be set before the first event.
  void CallWithPublished(std::function<void(const Event& event)> tell) { tell_ = std::move(tell); }
  // Marks the end of the log for all listeners.
  void Stop();
  // `call` is called after each event and after Stop, by the thread that publishes. It must not
  // wait.
  void CallOnNews(std::function<void()> call);

  // "<start time of this log>-<number>"; unique also across restarts.
  std::string IdOf(int64_t number) const;
  int64_t LastNumber() const;
  // The number in an id. Nothing if the id is from another log, or if events after it are no longer
  // kept.
  std::optional<int64_t> NumberOf(const std::string& id) const;

  struct Batch {
    std::vector<Event> events;
    // True if events were dropped. The listener must then fetch the complete state.
    bool has_gap = false;
    // True if Stop was called and no event is left.
    bool is_over = false;
    // Number of the last event that was examined. It may be of another flight.
    int64_t last_number = 0;
  };
  // The events after `number`. The batch ends with the event at which the total size of the data
  // exceeds `max_bytes`. An empty flight_id means all flights.
  Batch After(int64_t number, const std::string& flight_id, size_t max_bytes) const;

 private:
  void DropOld();

  std::string epoch_;
  std::function<void(const Event& event)> tell_ = [](const Event&) {};
  // Guards all members below.
  mutable std::mutex mutex_;
  std::function<void()> on_news_ = [] {};
  // The numbers of these events have no gap.
  std::deque<Event> events_;
  size_t num_bytes_ = 0;
  int64_t last_number_ = 0;
  bool is_over_ = false;
};

}  // namespace freelsd
