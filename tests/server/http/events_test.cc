#include "server/http/events.h"

#include <doctest/doctest.h>

#include "api/api.h"

namespace freelsd {
namespace {

TEST_CASE("event log: it keeps a bounded number of bytes, and who is behind learns of the gap") {
  EventLog log;
  const size_t size = kLimits.events.max_event_bytes;
  const size_t num_events = 2 * kLimits.events.max_log_bytes / size;
  for (size_t i = 0; i < num_events; ++i) log.Publish("job", "f", std::string(size, 'x'));
  CHECK(log.After(0, "", size).has_gap);
  const auto num_kept_at_most = static_cast<int64_t>(kLimits.events.max_log_bytes / size);
  CHECK_FALSE(log.NumberOf(log.IdOf(log.LastNumber() - num_kept_at_most)));
  CHECK(log.NumberOf(log.IdOf(log.LastNumber() - 1)));
}

TEST_CASE("event log: a batch ends with the event that exceeds its bytes, and goes on from there") {
  EventLog log;
  for (int i = 0; i < 10; ++i) log.Publish("frame", i % 2 == 0 ? "f" : "g", std::string(1000, 'x'));
  log.Stop();
  const EventLog::Batch first = log.After(0, "f", 2000);
  REQUIRE(first.events.size() == 2);
  CHECK(first.last_number == 3);
  CHECK_FALSE(first.is_over);
  const EventLog::Batch rest = log.After(first.last_number, "f", 1 << 20);
  CHECK(rest.events.size() == 3);
  CHECK(rest.last_number == 10);
  CHECK(rest.is_over);
}

TEST_CASE("event log: an event beyond the limit becomes a resync") {
  EventLog log;
  log.Publish("job", "f", std::string(kLimits.events.max_event_bytes + 1, 'x'));
  const EventLog::Batch batch = log.After(0, "f", 100);
  REQUIRE(batch.events.size() == 1);
  CHECK(batch.events[0].type == "resync");
  CHECK(batch.events[0].data == "{}");
}

TEST_CASE("event log: listeners are called for each event, and at the end") {
  EventLog log;
  int num_calls = 0;
  log.CallOnNews([&num_calls] { ++num_calls; });
  log.Publish("job", "f", "{}");
  log.Stop();
  CHECK(num_calls == 2);
}

}  // namespace
}  // namespace freelsd
