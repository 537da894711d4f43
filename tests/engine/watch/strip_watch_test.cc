// One photograph makes suspicious, two are sure, and silence is forgotten.
#include <doctest/doctest.h>

#include "engine/watch/watch.h"

namespace freelsd {
namespace {

// As sure as a car.
constexpr double kSure = 8.0;

StripLook Compared(double seconds,
                   const std::vector<Eigen::Vector2d>& places,
                   double evidence = kSure) {
  StripLook look;
  look.result = LookResult::kCompared;
  look.timestamp_us = static_cast<int64_t>(1e6 * seconds);
  look.compared_ratio = 1.0;
  for (const Eigen::Vector2d& place : places) {
    NewThing thing;
    thing.place_in_world << place, 0.0;
    thing.evidence = evidence;
    look.things.push_back(thing);
  }
  return look;
}

StripLook NotCompared(double seconds) {
  StripLook look;
  look.result = LookResult::kNotRegistered;
  look.timestamp_us = static_cast<int64_t>(1e6 * seconds);
  return look;
}

TEST_CASE("strip watch: a thing is told when a second photograph shows it") {
  StripWatch watch({});
  CHECK(watch.Add(Compared(0.0, {})).status == StripStatus::kNothingNew);
  CHECK(watch.Add(Compared(1.0, {{0.0, 0.0}})).status == StripStatus::kSuspected);
  const StripWatch::Report report = watch.Add(Compared(2.0, {{40.0, 0.0}, {1.0, 0.0}}));
  CHECK(report.status == StripStatus::kOccupied);
  REQUIRE(report.things.size() == 1);
  CHECK(report.things[0].place_in_world.x() == 1.0);
}

TEST_CASE("strip watch: a thing may move, but not faster than a car") {
  WatchOptions options;
  options.max_speed_mps = 10.0;
  options.place_error_m = 1.0;
  for (const auto& [distance_m, status] :
       {std::pair(10.9, StripStatus::kOccupied), std::pair(11.1, StripStatus::kSuspected)}) {
    StripWatch watch(options);
    watch.Add(Compared(0.0, {{0.0, 0.0}}));
    CHECK(watch.Add(Compared(1.0, {{distance_m, 0.0}})).status == status);
  }
}

TEST_CASE("strip watch: photographs without the thing between two that show it change nothing") {
  StripWatch watch({});
  watch.Add(Compared(0.0, {{0.0, 0.0}}));
  CHECK(watch.Add(NotCompared(1.0)).status == StripStatus::kSuspected);
  CHECK(watch.Add(Compared(2.0, {})).status == StripStatus::kNothingNew);
  CHECK(watch.Add(Compared(3.0, {{0.0, 0.0}})).status == StripStatus::kOccupied);
}

TEST_CASE("strip watch: what was seen long ago confirms nothing, and is no longer known") {
  WatchOptions options;
  options.max_wait_s = 5.0;
  StripWatch watch(options);
  CHECK(watch.Add(NotCompared(0.0)).status == StripStatus::kUnknown);
  watch.Add(Compared(1.0, {{0.0, 0.0}}));
  CHECK(watch.Add(NotCompared(6.5)).status == StripStatus::kUnknown);
  CHECK(watch.Add(Compared(7.0, {{0.0, 0.0}})).status == StripStatus::kSuspected);
}

TEST_CASE("strip watch: two faint things are told where they are near to each other") {
  WatchOptions options;
  const double faint = 0.5 * options.min_pair_evidence + 0.1;
  for (const auto& [distance_m, status] :
       {std::pair(0.2, StripStatus::kOccupied), std::pair(5.0, StripStatus::kSuspected)}) {
    StripWatch watch(options);
    watch.Add(Compared(0.0, {{0.0, 0.0}}, faint));
    CHECK(watch.Add(Compared(1.0, {{distance_m, 0.0}}, faint)).status == status);
  }
  StripWatch watch(options);
  watch.Add(Compared(0.0, {{0.0, 0.0}}, 0.4 * options.min_pair_evidence));
  const StripLook again = Compared(1.0, {{0.0, 0.0}}, 0.4 * options.min_pair_evidence);
  CHECK(watch.Add(again).status == StripStatus::kSuspected);
}

}  // namespace
}  // namespace freelsd
