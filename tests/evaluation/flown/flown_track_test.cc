// Tracks over a meadow made by hand.
#include "tests/evaluation/flown/flown_track.h"

#include <doctest/doctest.h>

namespace freelsd {
namespace {

constexpr double kTouchdownToleranceM = 1.0;

World Meadow() {
  WorldOptions options;
  options.size_m = 300.0;
  options.cell_size_m = 0.5;
  return MakeMeadowPlane(options);
}

Mosaic MosaicOf(World world) {
  Mosaic mosaic;
  mosaic.Add(std::move(world));
  return mosaic;
}

// Northwards at 10 m/s and 1 : 7, aimed at `aim_m` north of the told touchdown in the middle; then
// a ground roll.
FlownTrack TrackTo(const Mosaic& mosaic, double aim_m) {
  const LocalFrame frame(mosaic.origin());
  FlownTrack track;
  track.id = "track";
  track.touchdown = mosaic.origin();
  track.touchdown_uncertainty_m = 8.0;
  for (double north = -70.0; north <= aim_m + 15.0; north += 1.0) {
    const double height = std::max(0.0, (aim_m - north) / 7.0);
    track.points.push_back({(north + 70.0) / 10.0, frame.GeoFromWorld({0.0, north, height})});
  }
  return track;
}

TrackVerdict VerdictOf(const Mosaic& mosaic, const FlownTrack& track) {
  return TrackJudge(mosaic, *AircraftProfile("small")).Judge(track);
}

}  // namespace

TEST_CASE("flown track: a touchdown on a meadow is a landing in the told disc") {
  const Mosaic mosaic = MosaicOf(Meadow());
  const TrackVerdict verdict = VerdictOf(mosaic, TrackTo(mosaic, 3.0));
  CHECK(verdict.IsLanding());
  CHECK(verdict.is_in_disc);
  // Tufts are met a little earlier.
  CHECK(verdict.along_m <= 3.0 + kTouchdownToleranceM);
  CHECK(verdict.along_m > -3.0);
  CHECK(verdict.ground_speed_mps == doctest::Approx(10.0).epsilon(0.05));
}

TEST_CASE("flown track: beyond the disc it is a landing, but not in the disc") {
  const Mosaic mosaic = MosaicOf(Meadow());
  FlownTrack track = TrackTo(mosaic, 20.0);
  const TrackVerdict verdict = VerdictOf(mosaic, track);
  CHECK(verdict.IsLanding());
  CHECK_FALSE(verdict.is_in_disc);
  track.touchdown_uncertainty_m = 25.0;
  CHECK(VerdictOf(mosaic, track).is_in_disc);
}

TEST_CASE("flown track: a hedge on the final is hit, one on the roll is a fault") {
  World world = Meadow();
  world.Plant(Hedge{{-40.0, -20.0}, {40.0, -20.0}, 2.0, 5.0});
  const Mosaic before = MosaicOf(std::move(world));
  const TrackVerdict hit = VerdictOf(before, TrackTo(before, 0.0));
  CHECK(hit.hit == CoverName(Cover::kHedge));
  CHECK_FALSE(hit.IsLanding());

  world = Meadow();
  world.Plant(Hedge{{-40.0, 9.0}, {40.0, 9.0}, 1.0, 1.0});
  const Mosaic behind = MosaicOf(std::move(world));
  const TrackVerdict rolled = VerdictOf(behind, TrackTo(behind, 0.0));
  CHECK(rolled.hit.empty());
  CHECK_FALSE(rolled.roll_fault.empty());
  CHECK_FALSE(rolled.IsLanding());
}

TEST_CASE("flown track: a track that ends in the air has no contact") {
  const Mosaic mosaic = MosaicOf(Meadow());
  FlownTrack track = TrackTo(mosaic, 0.0);
  track.points.resize(20);
  CHECK_FALSE(VerdictOf(mosaic, track).has_contact);
}

TEST_CASE("flown track: fewer than two points are refused") {
  const Mosaic mosaic = MosaicOf(Meadow());
  CHECK_THROWS_AS(VerdictOf(mosaic, FlownTrack{}), std::invalid_argument);
}

}  // namespace freelsd
