#include "server/http/events.h"

#include <charconv>
#include <utility>

#include "api/api.h"
#include "server/http/stamps.h"

namespace freelsd {
namespace {

constexpr size_t kMaxNumKept = 4096;

size_t BytesOf(const Event& event) {
  return sizeof(Event) + event.type.size() + event.flight_id.size() + event.data.size();
}

}  // namespace

EventLog::EventLog() : epoch_(std::to_string(NowUs())) {}

void EventLog::Publish(const std::string& type,
                       const std::string& flight_id,
                       const std::string& data) {
  Relay(type, flight_id, data);
  tell_({0, type, flight_id, data});
}

void EventLog::Relay(const std::string& type,
                     const std::string& flight_id,
                     const std::string& data) {
  const bool is_too_large = data.size() > kLimits.events.max_event_bytes;
  const std::lock_guard lock(mutex_);
  events_.push_back(
      {++last_number_, is_too_large ? "resync" : type, flight_id, is_too_large ? "{}" : data});
  num_bytes_ += BytesOf(events_.back());
  DropOld();
  on_news_();
}

void EventLog::DropOld() {
  while (events_.size() > kMaxNumKept || num_bytes_ > kLimits.events.max_log_bytes) {
    num_bytes_ -= BytesOf(events_.front());
    events_.pop_front();
  }
}

void EventLog::Stop() {
  const std::lock_guard lock(mutex_);
  is_over_ = true;
  on_news_();
}

void EventLog::CallOnNews(std::function<void()> call) {
  const std::lock_guard lock(mutex_);
  on_news_ = std::move(call);
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

EventLog::Batch EventLog::After(int64_t number,
                                const std::string& flight_id,
                                size_t max_bytes) const {
  const std::lock_guard lock(mutex_);
  Batch batch;
  batch.last_number = last_number_;
  batch.is_over = is_over_;
  const int64_t oldest = events_.empty() ? last_number_ + 1 : events_.front().number;
  batch.has_gap = oldest > number + 1;
  if (batch.has_gap) return batch;
  size_t num_bytes = 0;
  for (size_t i = static_cast<size_t>(number + 1 - oldest); i < events_.size(); ++i) {
    const Event& event = events_[i];
    if (!flight_id.empty() && event.flight_id != flight_id) continue;
    batch.events.push_back(event);
    num_bytes += BytesOf(event);
    if (num_bytes <= max_bytes || i + 1 == events_.size()) continue;
    batch.last_number = event.number;
    batch.is_over = false;
    return batch;
  }
  return batch;
}

}  // namespace freelsd
