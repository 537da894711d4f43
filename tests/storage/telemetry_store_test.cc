#include "storage/telemetry_store.h"

#include <doctest/doctest.h>

#include "storage/storage.h"
#include "tests/storage/place.h"
#include "tests/storage/rows.h"

namespace freelsd {
namespace {

TEST_CASE("telemetry store: telemetry is found on both sides of a time, by kind") {
  const StoragePlace place;
  Storage storage(place.options());
  storage.flights.Insert(SomeFlight("f"));
  storage.telemetry.Put("f",
                        {{TelemetryKind::kPosition, 10, {47.0, 8.0, 400.0, 0.0}},
                         {TelemetryKind::kPosition, 20, {48.0, 8.0, 400.0, 0.0}},
                         {TelemetryKind::kWind, 12, {1.0, 2.0, 0.0, 0.0}}});
  storage.telemetry.Put("f", {{TelemetryKind::kPosition, 20, {49.0, 8.0, 400.0, 0.0}}});
  const auto pair = storage.telemetry.Around("f", TelemetryKind::kPosition, 15);
  REQUIRE(pair.before);
  REQUIRE(pair.after);
  CHECK(pair.before->timestamp_us == 10);
  CHECK(pair.after->values[0] == 49.0);
  CHECK_FALSE(storage.telemetry.Around("f", TelemetryKind::kWind, 15).after);
  CHECK_FALSE(storage.telemetry.Around("f", TelemetryKind::kAttitude, 15).before);
  CHECK(storage.telemetry.Around("f", TelemetryKind::kPosition, 20).before->timestamp_us == 20);
}

TEST_CASE(
    "telemetry store: what arrived last comes first, whatever its own time and the clock say") {
  const StoragePlace place;
  Storage storage(place.options());
  storage.flights.Insert(SomeFlight("f"));
  const auto put = [&](int64_t timestamp_us, int64_t arrived_at_us) {
    TelemetryRow row{TelemetryKind::kPosition, timestamp_us, {47.0, 8.0, 400.0, 0.0}};
    row.arrived_at_us = arrived_at_us;
    storage.telemetry.Put("f", {row});
  };
  put(500, 1000);
  put(100, 2000);
  // The clock was set back meanwhile.
  put(300, 50);
  std::vector<int64_t> timestamps, arrivals;
  for (const auto& row : storage.telemetry.LastArrived("f", TelemetryKind::kPosition, 3)) {
    timestamps.push_back(row.timestamp_us);
    arrivals.push_back(row.arrived_at_us);
  }
  CHECK(timestamps == std::vector<int64_t>{300, 100, 500});
  CHECK(arrivals == std::vector<int64_t>{2001, 2000, 1000});
  // A sample sent again is the latest again.
  put(500, 3000);
  CHECK(storage.telemetry.LastArrived("f", TelemetryKind::kPosition, 9).size() == 3);
  CHECK(storage.telemetry.LastArrived("f", TelemetryKind::kPosition, 1)[0].timestamp_us == 500);
  CHECK(storage.telemetry.LastArrived("f", TelemetryKind::kWind, 1).empty());
}

TEST_CASE("telemetry store: rows by their own time, and the one that arrived first") {
  const StoragePlace place;
  Storage storage(place.options());
  storage.flights.Insert(SomeFlight("f"));
  CHECK_FALSE(storage.telemetry.FirstArrived("f", TelemetryKind::kPosition));
  for (const int64_t timestamp_us : {300, 500, 100}) {
    storage.telemetry.Put("f", {{TelemetryKind::kPosition, timestamp_us, {47.0, 8.0, 400.0, 0.0}}});
  }
  const auto latest = storage.telemetry.Latest("f", TelemetryKind::kPosition, 2);
  REQUIRE(latest.size() == 2);
  CHECK(latest[0].timestamp_us == 500);
  CHECK(latest[1].timestamp_us == 300);
  CHECK(storage.telemetry.FirstArrived("f", TelemetryKind::kPosition)->timestamp_us == 300);
  CHECK(storage.telemetry.Latest("f", TelemetryKind::kWind, 2).empty());
}

TEST_CASE("telemetry store: nothing is written for a flight that does not exist") {
  const StoragePlace place;
  Storage storage(place.options());
  CHECK_FALSE(
      storage.telemetry.Put("f", {{TelemetryKind::kPosition, 10, {47.0, 8.0, 400.0, 0.0}}}));
  storage.flights.Insert(SomeFlight("f"));
  CHECK(storage.telemetry.Put("f", {{TelemetryKind::kPosition, 20, {47.0, 8.0, 400.0, 0.0}}}));
  CHECK_FALSE(storage.telemetry.Around("f", TelemetryKind::kPosition, 15).before);
}

}  // namespace
}  // namespace freelsd
