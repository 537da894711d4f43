#include "storage/telemetry_store.h"

#include <doctest/doctest.h>

#include "storage/storage.h"
#include "tests/storage/rows.h"

namespace freelsd {
namespace {

TEST_CASE("telemetry store: telemetry is found on both sides of a time, by kind") {
  const TemporaryFolder folder;
  Storage storage(folder.path());
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

TEST_CASE("telemetry store: nothing is written for a flight that does not exist") {
  const TemporaryFolder folder;
  Storage storage(folder.path());
  CHECK_FALSE(
      storage.telemetry.Put("f", {{TelemetryKind::kPosition, 10, {47.0, 8.0, 400.0, 0.0}}}));
  storage.flights.Insert(SomeFlight("f"));
  CHECK(storage.telemetry.Put("f", {{TelemetryKind::kPosition, 20, {47.0, 8.0, 400.0, 0.0}}}));
  CHECK_FALSE(storage.telemetry.Around("f", TelemetryKind::kPosition, 15).before);
}

}  // namespace
}  // namespace freelsd
