// The latest pose and wind of a flight, also after a link was cut.
#include "server/recall/live_pose/live_pose.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include "api/api.h"
#include "server/intake/intake.h"
#include "tests/server/recall/bad_clock.h"
#include "tests/server/test_server.h"

namespace freelsd {
namespace {

constexpr int64_t kSecondUs = 1000000;
constexpr int64_t kNowUs = 1700000000 * kSecondUs;

struct FlightInStorage {
  TemporaryFolder folder;
  Storage storage{StorageAt(folder.path())};

  FlightInStorage() {
    FlightRow flight;
    flight.id = std::string("f");
    flight.request_json = ParseFlightRequest(R"({"name":"f"})").canonical_json;
    storage.flights.Insert(flight);
  }

  // A position flown at that second, 20 m/s to the north, that arrives at that second.
  void Fly(int flown_s, int arrived_s) {
    const nlohmann::json place{{"latitude_deg", 47.0 + flown_s * 20.0 / 111195.0},
                               {"longitude_deg", 8.0},
                               {"altitude_m", 500.0}};
    Put({{"position", place}}, flown_s, arrived_s);
  }
  // The position of that second, with another time.
  void FlyAhead(int flown_s, int ahead_s) {
    Fly(flown_s, flown_s);
    std::vector<TelemetryRow> rows = {
        storage.telemetry.Recent("f", TelemetryKind::kPosition, 1).back()};
    rows[0].timestamp_us += ahead_s * kSecondUs;
    rows[0].values[0] += 1.35;
    REQUIRE(storage.telemetry.Put("f", rows));
  }
  void Blow(const nlohmann::json& wind, int blown_s, int arrived_s) {
    Put({{"wind", wind}}, blown_s, arrived_s);
  }
  LivePose Pose(int now_s) { return LivePoseOf(storage, "f", kNowUs + now_s * kSecondUs).value(); }

 private:
  void Put(nlohmann::json line, int own_s, int arrived_s) {
    line["timestamp_us"] = kNowUs + own_s * kSecondUs;
    std::vector<TelemetryRow> rows = ParseTelemetryLine(line.dump());
    for (TelemetryRow& row : rows) row.arrived_at_us = kNowUs + arrived_s * kSecondUs;
    REQUIRE(storage.telemetry.Put("f", rows));
  }
};

TEST_CASE("live pose: what a link kept during an outage is not shown as fresh") {
  FlightInStorage flight;
  for (int s = 0; s < 10; ++s) flight.Fly(s, s);
  CHECK(flight.Pose(9).age_s == doctest::Approx(0.0));
  CHECK(flight.Pose(9).heading_deg);
  // Nothing arrives from 10 to 70; then the oldest comes first.
  for (int s = 10; s < 30; ++s) flight.Fly(s, 70);
  const LivePose late = flight.Pose(70);
  CHECK(late.timestamp_us == kNowUs + 29 * kSecondUs);
  CHECK(late.age_s.value() == doctest::Approx(41.0).epsilon(0.01));
  CHECK_FALSE(late.heading_deg);
  for (int s = 30; s <= 70; ++s) flight.Fly(s, 71);
  CHECK(flight.Pose(71).age_s.value() < 1.5);
  CHECK(flight.Pose(71).heading_deg);
}

TEST_CASE("live pose: an old position that arrives after a new one does not replace it") {
  FlightInStorage flight;
  for (int s = 100; s < 110; ++s) flight.Fly(s, s);
  for (int s = 0; s < 100; ++s) flight.Fly(s, 110);
  const LivePose pose = flight.Pose(110);
  CHECK(pose.timestamp_us == kNowUs + 109 * kSecondUs);
  CHECK(pose.age_s.value() < 1.5);
}

TEST_CASE("live pose: a flight of which all arrives late is late") {
  FlightInStorage flight;
  for (int s = 0; s < 10; ++s) flight.Fly(s, 1000);
  CHECK(flight.Pose(1000).age_s.value() == doctest::Approx(991.0).epsilon(0.001));
}

TEST_CASE(
    "live pose: photographs of a batch are as old as they say, streamed ones as their arrival") {
  FlightInStorage flight;
  const auto take = [&](const char* id, bool is_from_batch, int64_t taken_at_us) {
    FrameRow frame;
    frame.flight_id = "f";
    frame.id = id;
    frame.sha256 = std::string(64, 'a');
    flight.storage.images.Write(frame.sha256, "pixels");
    frame.meta_json =
        nlohmann::json{
            {"timestamp_us", taken_at_us},
            {"position", {{"latitude_deg", 47.0}, {"longitude_deg", 8.0}, {"altitude_m", 500.0}}}}
            .dump();
    frame.is_from_batch = is_from_batch;
    frame.arrived_at_us = kNowUs;
    flight.storage.frames.Insert("f", {frame});
  };
  take("yesterday", true, kNowUs - 86400 * kSecondUs);
  CHECK(flight.Pose(60).age_s == doctest::Approx(86460.0));
  CHECK_FALSE(flight.Pose(60).heading_deg);
  take("clock-never-set", true, 1000 * kSecondUs);
  CHECK_FALSE(flight.Pose(60).age_s);
  take("streamed", false, kNowUs - 86400 * kSecondUs);
  CHECK(flight.Pose(60).age_s == doctest::Approx(60.0).epsilon(0.01));
}

TEST_CASE("one sample ahead: the aircraft is where its good samples say, after each of them") {
  for (const int ahead_s : {100, 12 * 3600, 86390}) {
    INFO(ahead_s);
    FlightInStorage flight;
    for (int s = 0; s < 30; ++s) flight.Fly(s, s);
    flight.FlyAhead(30, ahead_s);
    // 150 km away.
    for (int s = 30; s < 60; ++s) {
      if (s > 30) flight.Fly(s, s);
      const LivePose pose = flight.Pose(s);
      CHECK(pose.timestamp_us == kNowUs + s * kSecondUs);
      CHECK(pose.age_s.value() < 0.1);
      CHECK(std::abs(std::remainder(pose.heading_deg.value(), 360.0)) < 1e-6);
    }
  }
}

TEST_CASE("one sample ahead: fifteen good winds count, not the one of half a day ahead") {
  FlightInStorage flight;
  for (int s = 0; s < 15; ++s) {
    flight.Fly(s, s);
    flight.Blow({{"east_mps", 1.0}, {"north_mps", 2.0}}, s, s);
  }
  flight.Blow({{"east_mps", 9.0}, {"north_mps", 0.0}}, 15 + 43200, 15);
  CHECK(flight.Pose(15).wind->wind_in_world.x() == 1.0);
  CHECK(flight.Pose(15).wind->age_s == doctest::Approx(1.0));
  // The only wind that there is: it is told, and its age is unknown.
  FlightInStorage other;
  for (int s = 0; s < 15; ++s) other.Fly(s, s);
  other.Blow({{"east_mps", 9.0}, {"north_mps", 0.0}}, 15 + 43200, 15);
  CHECK_FALSE(other.Pose(15).wind->age_s);
}

// Of all poses that were told: how much older than told, how old at the end.
struct PoseErrors {
  double most_understated_s = 0.0, oldest_at_end_s = 0.0;
  bool is_outlier_shown = false;
};

PoseErrors ErrorsWith(ClockFault fault, uint32_t seed) {
  constexpr int kNumSeconds = 240;
  constexpr size_t kNumTogether = 8;
  FlightInStorage flight;
  PoseErrors errors;
  std::map<int64_t, TimedSample> by_time;
  std::vector<TelemetryRow> rows;
  for (const TimedSample& sample : SamplesOf(fault, kNumSeconds, kNowUs, seed)) {
    rows.push_back({TelemetryKind::kPosition, sample.timestamp_us, {47.0, 8.0, 400.0, 0.0}});
    rows.back().arrived_at_us = sample.arrived_at_us;
    by_time[sample.timestamp_us] = sample;
    if (rows.size() < kNumTogether) continue;
    REQUIRE(flight.storage.telemetry.Put("f", std::exchange(rows, {})));
    const int64_t now_us = sample.arrived_at_us;
    const LivePose pose = LivePoseOf(flight.storage, "f", now_us).value();
    const TimedSample& shown = by_time.at(pose.timestamp_us.value());
    const double age_s = 1e-6 * static_cast<double>(now_us - shown.taken_at_us);
    const double told_s = pose.age_s.value_or(1e9);
    errors.most_understated_s = std::max(errors.most_understated_s, age_s - told_s);
    errors.is_outlier_shown |= shown.is_outlier && pose.age_s;
    const bool is_end = now_us > kNowUs + (kNumSeconds - 20) * kSecondUs;
    if (is_end) errors.oldest_at_end_s = std::max(errors.oldest_at_end_s, told_s);
  }
  return errors;
}

TEST_CASE("one sample ahead: with any bad clock no pose is older than told, and none stays") {
  for (const ClockFault fault : {ClockFault::kNone,
                                 ClockFault::kConstant,
                                 ClockFault::kOutliers,
                                 ClockFault::kFirstIsOutlier,
                                 ClockFault::kBurst,
                                 ClockFault::kStep,
                                 ClockFault::kOutage}) {
    for (uint32_t seed = 0; seed < 2; ++seed) {
      INFO("fault ", static_cast<int>(fault), ", seed ", seed);
      const PoseErrors errors = ErrorsWith(fault, seed);
      CHECK(errors.most_understated_s < 2.1);
      CHECK(errors.oldest_at_end_s < 3.0);
      CHECK_FALSE(errors.is_outlier_shown);
    }
  }
}

TEST_CASE("live wind: its source and deviation are those that were sent") {
  FlightInStorage flight;
  flight.Fly(0, 0);
  flight.Blow({{"east_mps", 1.0}, {"north_mps", 2.0}}, 0, 0);
  CHECK_FALSE(flight.Pose(0).wind->source);
  CHECK_FALSE(flight.Pose(0).wind->sd_mps);
  flight.Blow(
      {{"east_mps", 3.0}, {"north_mps", 2.0}, {"source", "autopilot"}, {"sd_mps", 0.5}}, 1, 1);
  const LiveWind wind = flight.Pose(2).wind.value();
  CHECK(wind.wind_in_world.x() == 3.0);
  CHECK(wind.source == "autopilot");
  CHECK(wind.sd_mps == 0.5);
  CHECK(wind.age_s == doctest::Approx(1.0));
}

TEST_CASE("live wind: one from drift counts only where no other one is recent") {
  FlightInStorage flight;
  const nlohmann::json given{{"east_mps", 1.0}, {"north_mps", 0.0}, {"source", "autopilot"}};
  const nlohmann::json drift{
      {"east_mps", 5.0}, {"north_mps", 0.0}, {"source", "drift"}, {"sd_mps", 0.4}};
  flight.Fly(0, 0);
  flight.Blow(drift, 0, 0);
  CHECK(flight.Pose(1).wind->source == "drift");
  flight.Blow(given, 10, 10);
  for (int s = 11; s < 60; ++s) flight.Blow(drift, s, s);
  CHECK(flight.Pose(59).wind->source == "autopilot");
  flight.Blow(drift, 75, 75);
  CHECK(flight.Pose(75).wind->source == "drift");
}

TEST_CASE("telemetry: a wind's source and deviation are checked by name") {
  const auto fault = [](const nlohmann::json& wind) -> std::string {
    nlohmann::json whole{{"east_mps", 1.0}, {"north_mps", 2.0}};
    whole.update(wind);
    try {
      ParseTelemetryLine(nlohmann::json{{"timestamp_us", 1}, {"wind", whole}}.dump());
    } catch (const ApiError& error) {
      return error.errors().at(0).pointer;
    }
    return "none";
  };
  CHECK(fault({{"source", "drift"}, {"sd_mps", 1.5}}) == "none");
  CHECK(fault({{"source", nullptr}, {"sd_mps", nullptr}}) == "none");
  CHECK(fault({{"source", "guess"}}) == "/wind/source");
  CHECK(fault({{"source", 1}}) == "/wind/source");
  CHECK(fault({{"source", ""}}) == "/wind/source");
  CHECK(fault({{"sd_mps", 0.0}}) == "/wind/sd_mps");
  CHECK(fault({{"sd_mps", "1"}}) == "/wind/sd_mps");
  CHECK(fault({{"gusts_mps", 3.0}}) == "/wind/gusts_mps");
}

}  // namespace
}  // namespace freelsd
