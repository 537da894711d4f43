#include "storage/telemetry_store.h"

#include <array>
#include <atomic>
#include <set>
#include <string>
#include <thread>
#include <vector>

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

std::vector<int64_t> TimesOf(const std::vector<TelemetryRow>& rows) {
  std::vector<int64_t> timestamps_us;
  timestamps_us.reserve(rows.size());
  for (const TelemetryRow& row : rows) timestamps_us.push_back(row.timestamp_us);
  return timestamps_us;
}

TEST_CASE("telemetry store: rows in the order of arrival, whatever their own times and the clock") {
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
  const auto recent = [&storage](int max_num_rows) {
    return storage.telemetry.Recent("f", TelemetryKind::kPosition, max_num_rows);
  };
  std::vector<int64_t> arrivals_us;
  for (const auto& row : recent(3)) arrivals_us.push_back(row.arrived_at_us);
  CHECK(TimesOf(recent(3)) == std::vector<int64_t>{500, 100, 300});
  CHECK(arrivals_us == std::vector<int64_t>{1000, 2000, 2001});
  // A sample sent again is the latest again.
  put(500, 3000);
  CHECK(TimesOf(recent(9)) == std::vector<int64_t>{100, 300, 500});
  CHECK(storage.telemetry.Recent("f", TelemetryKind::kWind, 1).empty());
}

TEST_CASE("telemetry store: the rows that arrived last, and others a second apart") {
  const StoragePlace place;
  Storage storage(place.options());
  storage.flights.Insert(SomeFlight("f"));
  const auto recent = [&storage](int max_num_rows) {
    return TimesOf(storage.telemetry.Recent("f", TelemetryKind::kPosition, max_num_rows));
  };
  CHECK(recent(2).empty());
  // Own times run back; six arrive in a second, and the last ten within a millisecond.
  std::vector<TelemetryRow> rows;
  for (int64_t i = 0; i < 60; ++i) {
    TelemetryRow row{TelemetryKind::kPosition, 1000 - i, {47.0, 8.0, 400.0, 0.0}};
    row.arrived_at_us = 5000000 + (i < 50 ? i * 170000 : 8400000 + i);
    rows.push_back(row);
  }
  REQUIRE(storage.telemetry.Put("f", rows));
  CHECK(recent(1) == std::vector<int64_t>{941});
  CHECK(recent(3) == std::vector<int64_t>{963, 957, 943, 942, 941});
  CHECK(recent(100).size() == 60);
}

TEST_CASE("telemetry store: what several threads give is stored, each in the order it was given") {
  const StoragePlace place;
  Storage storage(place.options());
  constexpr int kNumThreads = 8, kNumRows = 40;
  for (int i = 0; i < kNumThreads / 2; ++i) storage.flights.Insert(SomeFlight(std::to_string(i)));
  std::vector<std::thread> threads;
  threads.reserve(kNumThreads);
  std::atomic<int> num_refused{0};
  for (int i = 0; i < kNumThreads; ++i) {
    threads.emplace_back([&, i] {
      for (int64_t row = 0; row < kNumRows; ++row) {
        const int64_t timestamp_us = 1000 * (i % 2) + row;
        const TelemetryRow sample{TelemetryKind::kWind, timestamp_us, {1.0, 2.0, 0.0, 0.0}};
        if (!storage.telemetry.Put(std::to_string(i / 2), {sample})) ++num_refused;
        if (storage.telemetry.Put("none", {sample})) ++num_refused;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  CHECK(num_refused == 0);
  for (int i = 0; i < kNumThreads / 2; ++i) {
    const auto rows = storage.telemetry.Recent(std::to_string(i), TelemetryKind::kWind, 1000);
    REQUIRE(rows.size() == 2 * kNumRows);
    std::array<int64_t, 2> next_us{0, 1000};
    std::set<int64_t> arrivals_us;
    for (const TelemetryRow& row : rows) {
      CHECK(row.timestamp_us == next_us.at(row.timestamp_us < 1000 ? 0 : 1)++);
      arrivals_us.insert(row.arrived_at_us);
    }
    CHECK(arrivals_us.size() == rows.size());
  }
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
