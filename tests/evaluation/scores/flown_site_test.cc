// Worlds made by hand, for which the share of failures is known in closed form.
#include "tests/evaluation/scores/flown_site.h"

#include <cmath>

#include <doctest/doctest.h>

#include "tests/evaluation/scores/flight_draws.h"

namespace freelsd {
namespace {

constexpr double kFinalM = 60.0;
// Path angle of 4 degrees.
constexpr double kStartM = 4.195;
// Of `small` in still air, at its path angle, less the wind of the world.
constexpr double kPlannedSpeedMps = 9.903 - 4.0;
constexpr int kNumSeeds = 10;

World Meadow() {
  WorldOptions options;
  options.size_m = 300.0;
  options.cell_size_m = 0.5;
  return MakeMeadowPlane(options);
}

// Calls `change(row, col)` for the cells in a rectangle.
template <typename Change>
void ChangeCells(const World& world, double west, double east, double half_height, Change change) {
  for (int row = 0; row < world.num_cells(); ++row) {
    for (int col = 0; col < world.num_cells(); ++col) {
      const double x = world.CellCenter(col), y = world.CellCenter(row);
      if (x > west && x < east && std::abs(y) < half_height) change(row, col);
    }
  }
}

// Across the final, 0.5 m thick: one column of cells that starts at `west`.
void BuildWall(World& world, double west, double height_m, Cover cover) {
  ChangeCells(world, west, west + 0.5, 40.0, [&](int row, int col) {
    world.surface(row, col) = static_cast<float>(height_m);
    world.cover(row, col) = static_cast<uint8_t>(cover);
  });
}

// Touches down in the middle, from the east, against the wind.
Site SiteInTheMiddle(double height_of_start, double height_in_world = 0.0) {
  Site site;
  site.plan.verdict = Verdict::kUnverified;
  Approach approach;
  approach.touchdown_in_world = {0.0, 0.0, height_in_world};
  approach.approach_start_in_world = {kFinalM, 0.0, height_in_world + height_of_start};
  approach.ground_speed = kPlannedSpeedMps;
  site.plan.approach = approach;
  return site;
}

FlownSite FlyOver(const World& world, const Site& site, uint64_t seed = 1) {
  const Aircraft aircraft = AircraftProfile("small").value();
  return FlySite(world, MakeTruthMap(world, aircraft), aircraft, site, seed);
}

// Share of failures over many series.
double FailureRatio(const World& world, const Site& site) {
  const Aircraft aircraft = AircraftProfile("small").value();
  const TruthMap truth = MakeTruthMap(world, aircraft);
  double num_failed = 0.0, num_flown = 0.0;
  for (uint64_t seed = 0; seed < kNumSeeds; ++seed) {
    const FlownSite flown = FlySite(world, truth, aircraft, site, seed);
    num_failed += flown.num_failed;
    num_flown += flown.num_flown;
  }
  return num_failed / num_flown;
}

// One axis of two normal numbers within a disc of two deviations is below `limit`, in deviations.
double ShareBelow(double limit) {
  constexpr double kStep = 1e-3;
  double below = 0.0, all = 0.0;
  for (double x = -2.0; x < 2.0; x += kStep) {
    const double half_chord = std::sqrt(4.0 - x * x);
    const double weight = std::exp(-0.5 * x * x) * std::erf(half_chord / std::sqrt(2.0));
    all += weight;
    if (x < limit) below += weight;
  }
  return below / all;
}

TEST_CASE("flown site: on a clean meadow no landing fails") {
  const FlownSite flown = FlyOver(Meadow(), SiteInTheMiddle(10.0));
  CHECK(flown.num_flown == 200);
  CHECK(flown.num_failed == 0);
  CHECK(flown.num_failed_thin == 0);
  CHECK(flown.absolute.num_failed == 0);
  CHECK(flown.absolute.num_short + flown.absolute.num_long == 0);
}

TEST_CASE("flown site: the same seed gives the same series, another seed another one") {
  World world = Meadow();
  BuildWall(world, 10.0, 2.0, Cover::kHouse);
  const Site site = SiteInTheMiddle(10.0);
  CHECK(FlyOver(world, site, 5).num_failed == FlyOver(world, site, 5).num_failed);
  DrawOptions options;
  options.disc_radius_m = 8.0;
  CHECK(DrawFlights(5, options)[0].along == DrawFlights(5, options)[0].along);
  CHECK(DrawFlights(5, options)[0].along != DrawFlights(6, options)[0].along);
}

TEST_CASE("flown site: errors stay in the disc and have half its radius as deviation") {
  DrawOptions options;
  options.num_flights = 20000;
  options.disc_radius_m = 8.0;
  options.wind_sd_mps = 0.5;
  Sums along, across, wind;
  for (const FlightDraw& draw : DrawFlights(1, options)) {
    CHECK(std::hypot(draw.along, draw.across) <= options.disc_radius_m);
    along.Add(draw.along);
    across.Add(draw.across);
    wind.Add(draw.wind_in_world.x());
  }
  // Cut off at two deviations, a normal number of deviation 4 has 3.32: 1 - 2 e^-2 / (1 - e^-2).
  constexpr double kSdM = 3.316;
  CHECK(along.Sd() == doctest::Approx(kSdM).epsilon(0.02));
  CHECK(across.Sd() == doctest::Approx(kSdM).epsilon(0.02));
  CHECK(wind.Sd() == doctest::Approx(0.5).epsilon(0.02));
}

TEST_CASE("flown site: a wall before the threshold stops the share of flights that are low there") {
  constexpr double kWestM = 10.0, kHeightM = 2.0;
  World world = Meadow();
  BuildWall(world, kWestM, kHeightM, Cover::kHouse);
  // The path is kHeightM above the touchdown at 12 m; it is lower at the wall if it ends before.
  const double limit = kFinalM * kHeightM / 10.0 - kWestM;
  constexpr double kSdM = 4.0, kTolerance = 0.04;
  const double expected = ShareBelow(limit / kSdM);
  CHECK(expected == doctest::Approx(0.69).epsilon(0.05));
  CHECK(std::abs(FailureRatio(world, SiteInTheMiddle(10.0)) - expected) < kTolerance);
  const FlownSite flown = FlyOver(world, SiteInTheMiddle(10.0));
  CHECK(flown.causes.at("final: house") == flown.num_failed);
}

TEST_CASE("flown site: a tower beside the final stops the flights that pass too near") {
  constexpr double kSideM = 7.0;
  World world = Meadow();
  for (int col = world.CellIndex(20.0); col < world.CellIndex(22.0); ++col) {
    for (int row = world.CellIndex(kSideM); row < world.CellIndex(kSideM + 10.0); ++row) {
      world.surface(row, col) = 30.0f;
      world.cover(row, col) = static_cast<uint8_t>(Cover::kHouse);
    }
  }
  const double half_width = AircraftProfile("small")->path_half_width_m;
  constexpr double kSdM = 4.0, kTolerance = 0.04;
  const double expected = 1.0 - ShareBelow((kSideM - half_width) / kSdM);
  CHECK(std::abs(FailureRatio(world, SiteInTheMiddle(10.0)) - expected) < kTolerance);
}

TEST_CASE("flown site: landing short on free ground is no failure") {
  World world = Meadow();
  // A gentle rise, higher than the path of many flights.
  constexpr double kMiddleM = 15.0, kSdM = 8.0, kRiseM = 0.8;
  for (int row = 0; row < world.num_cells(); ++row) {
    for (int col = 0; col < world.num_cells(); ++col) {
      const double off = (world.CellCenter(col) - kMiddleM) / kSdM;
      world.ground(row, col) = static_cast<float>(kRiseM * std::exp(-0.5 * off * off));
    }
  }
  world.surface = world.ground.clone();
  // The touchdown itself is 0.14 m up the rise.
  const FlownSite flown = FlyOver(world, SiteInTheMiddle(3.0, 0.14));
  CHECK(flown.num_failed == 0);
  CHECK(flown.absolute.num_failed == 0);
  CHECK(flown.absolute.num_short > 50);
  // The same with a ditch where those who land short roll.
  ChangeCells(world, 2.0, 3.0, 40.0, [&](int row, int col) {
    world.cover(row, col) = static_cast<uint8_t>(Cover::kDitch);
  });
  CHECK(FlyOver(world, SiteInTheMiddle(3.0, 0.14)).causes.at("roll: ditch") > 50);
}

TEST_CASE("flown site: a ground roll grows with the square of the ground speed") {
  World world = Meadow();
  // Beyond the disc and the roll at the planned speed.
  constexpr double kDitchM = 30.0;
  ChangeCells(world, -kDitchM - 1.0, -kDitchM, 40.0, [&](int row, int col) {
    world.cover(row, col) = static_cast<uint8_t>(Cover::kDitch);
  });
  Site site = SiteInTheMiddle(10.0);
  CHECK(FlyOver(world, site).num_failed == 0);
  // Planned for more wind than there is: the roll is 2.25 times as long.
  site.plan.approach->ground_speed = kPlannedSpeedMps / 1.5;
  CHECK(FlyOver(world, site).causes.at("roll: ditch") > 100);
}

TEST_CASE("flown site: what a wire or a fence stops is counted as thin") {
  World fenced = Meadow();
  fenced.Build(Fence{.start = {20.0, -30.0}, .end = {20.0, 30.0}, .height_m = 5.0});
  const FlownSite by_fence = FlyOver(fenced, SiteInTheMiddle(10.0));
  CHECK(by_fence.num_failed == 0);
  CHECK(by_fence.num_failed_thin == 200);
  CHECK(by_fence.thin_causes.at("final: fence") == 200);
  World wired = Meadow();
  wired.Build(
      PowerLine{.start = {30.0, -60.0}, .end = {30.0, 60.0}, .height_m = 7.0, .spacing_m = 120.0});
  const FlownSite by_wire = FlyOver(wired, SiteInTheMiddle(10.0));
  CHECK(by_wire.num_failed == 0);
  CHECK(by_wire.thin_causes.at("final: wire") == 200);
}

TEST_CASE("flown site: a map that is 3 m too high or too low moves a 4 degree final by 43 m") {
  constexpr double kBiasM = 3.0, kMoveM = 42.9;
  const World world = Meadow();
  const FlownSite high = FlyOver(world, SiteInTheMiddle(kStartM, kBiasM));
  CHECK(high.height_bias == doctest::Approx(kBiasM));
  CHECK(high.absolute.num_long == 200);
  CHECK(high.absolute.landing_place.Mean() == doctest::Approx(kMoveM).epsilon(0.03));
  const FlownSite low = FlyOver(world, SiteInTheMiddle(kStartM, -kBiasM));
  CHECK(low.absolute.num_short == 200);
  CHECK(low.absolute.landing_place.Mean() == doctest::Approx(-kMoveM).epsilon(0.03));
  CHECK(high.num_failed + low.num_failed == 0);
  // A wood where the long ones come down.
  World wooded = Meadow();
  ChangeCells(wooded, -60.0, -30.0, 40.0, [&](int row, int col) {
    wooded.surface(row, col) = 6.0f;
    wooded.cover(row, col) = static_cast<uint8_t>(Cover::kTree);
  });
  const FlownSite into_wood = FlyOver(wooded, SiteInTheMiddle(kStartM, kBiasM));
  CHECK(into_wood.num_failed == 0);
  CHECK(into_wood.absolute.num_failed == 200);
}

}  // namespace
}  // namespace freelsd
