#include "server/http/events.h"

#include <charconv>

#include "server/http/stamps.h"

namespace freelsd {
namespace {

constexpr size_t kMaxNumKept = 4096;

}  // namespace

EventLog::EventLog() : epoch_(std::to_string(NowUs())) {}

void EventLog::Publish(const std::string& type,
                       const std::string& flight_id,
                       const std::string& data) {
  {
    const std::lock_guard lock(mutex_);
    events_.push_back({++last_number_, type, flight_id, data});
    if (events_.size() > kMaxNumKept) events_.pop_front();
  }
  changed_.notify_all();
}

void EventLog::Stop() {
  {
    const std::lock_guard lock(mutex_);
    is_over_ = true;
  }
  changed_.notify_all();
}

std::string EventLog::IdOf(int64_t number) const { return epoch_ + "-" + std::to_string(number); }

int64_t EventLog::LastNumber() const {
  const std::lock_guard lock(mutex_);
  return last_number_;
}

std::optional<int64_t> EventLog::NumberOf(const std::string& id) const {
  const std::string prefix = epoch_ + "-";
  if (!id.starts_with(prefix)) return std::nullopt;
  int64_t number = 0;
  const char* const end = id.data() + id.size();
  const auto [stopped_at, error] = std::from_chars(id.data() + prefix.size(), end, number);
  if (error != std::errc() || stopped_at != end) return std::nullopt;
  const std::lock_guard lock(mutex_);
  const int64_t oldest = events_.empty() ? last_number_ + 1 : events_.front().number;
  if (number + 1 < oldest || number > last_number_) return std::nullopt;
  return number;
}

EventLog::Batch EventLog::WaitAfter(int64_t number,
                                    const std::string& flight_id,
                                    std::chrono::steady_clock::time_point deadline) const {
  const auto is_wanted = [&](const Event& event) {
    return event.number > number && (flight_id.empty() || event.flight_id == flight_id);
  };
  std::unique_lock lock(mutex_);
  while (true) {
    Batch batch;
    batch.has_gap = !events_.empty() && events_.front().number > number + 1;
    for (const Event& event : events_) {
      if (is_wanted(event)) batch.events.push_back(event);
    }
    batch.is_over = is_over_;
    batch.last_number = last_number_;
    if (is_over_ || batch.has_gap || !batch.events.empty()) return batch;
    // Events of other flights do not count as a gap for this listener.
    number = last_number_;
    if (changed_.wait_until(lock, deadline) == std::cv_status::timeout) return batch;
  }
}

}  // namespace freelsd
