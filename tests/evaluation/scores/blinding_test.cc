// A map that is wrong on purpose must be noticed by the judge.
#include "tests/evaluation/scores/blinding.h"

#include <algorithm>

#include <doctest/doctest.h>

#include "tests/evaluation/scores/decoys.h"
#include "tests/evaluation/scores/flown_site.h"
#include "tests/evaluation/site_score.h"
#include "tests/evaluation/truth_run.h"

namespace freelsd {
namespace {

constexpr double kSizeM = 300.0;
// Room for the disc, the map's margin and half a cell's diagonal, and little more.
constexpr double kStripWidthM = 24.0;

void Cultivate(World& world, double west, double east, double south, double north) {
  for (int row = 0; row < world.num_cells(); ++row) {
    for (int col = 0; col < world.num_cells(); ++col) {
      const double x = world.CellCenter(col), y = world.CellCenter(row);
      if (x < west || x > east || y < south || y > north) continue;
      world.cover(row, col) = static_cast<uint8_t>(Cover::kSoil);
    }
  }
}

// A strip of meadow between two fields of soil; wind blows north, along the strip.
Scenario NarrowMeadow() {
  WorldOptions options;
  options.size_m = kSizeM;
  options.cell_size_m = 0.5;
  Scenario scenario;
  scenario.world = MakeMeadowPlane(options);
  scenario.world.wind_in_world = {0.0, 4.0};
  Cultivate(scenario.world, -kSizeM, -0.5 * kStripWidthM, -kSizeM, kSizeM);
  Cultivate(scenario.world, 0.5 * kStripWidthM, kSizeM, -kSizeM, kSizeM);
  scenario.aircraft = AircraftProfile("small").value();
  scenario.seen = cv::Mat1b(static_cast<int>(kSizeM), static_cast<int>(kSizeM), uint8_t{255});
  return scenario;
}

struct Truth {
  TruthMap map;
  Fields fields;
  EngineRun run;

  explicit Truth(const Scenario& scenario)
      : map(MakeTruthMap(scenario.world, scenario.aircraft)),
        fields(FindFields(scenario.world, map, scenario.aircraft, scenario.seen)),
        run(RunOnTruth(scenario, map, fields, ApproachOptions{})) {}
};

int64_t CountFalseSafe(const Scenario& scenario, const Truth& truth, const EngineRun& run) {
  const std::vector<Site>& sites = run.evaluation.sites;
  return std::count_if(sites.begin(), sites.end(), [&](const Site& site) {
    const auto score =
        ScorePlan(scenario.world, truth.map, scenario.aircraft, site.plan, Eigen::Vector2d::Zero());
    return score && score->IsFalseSafe(site.plan.verdict);
  });
}

EngineRun Blind(const Scenario& scenario, const Truth& truth, Blinding blinding) {
  return RunBlinded(scenario, truth.map, truth.fields, truth.run, blinding, ApproachOptions{});
}

TEST_CASE(
    "blinding: without hazards, with a shift, and with kinds exchanged sites are false safe") {
  const Scenario scenario = NarrowMeadow();
  const Truth truth(scenario);
  REQUIRE(truth.fields.fields.size() == 1);
  REQUIRE(truth.run.evaluation.sites[0].plan.verdict != Verdict::kRejected);
  CHECK(CountFalseSafe(scenario, truth, truth.run) == 0);
  for (const Blinding blinding : {Blinding::kHazards, Blinding::kShift, Blinding::kKinds}) {
    CAPTURE(static_cast<int>(blinding));
    CHECK(CountFalseSafe(scenario, truth, Blind(scenario, truth, blinding)) > 0);
  }
}

TEST_CASE("blinding: flat heights lead finals into trees") {
  Scenario scenario = NarrowMeadow();
  // Finals to the meadow south of the wall come from the north. They clear 4 m, and not 8 m.
  Cultivate(scenario.world, -kSizeM, kSizeM, -kSizeM, -115.0);
  for (int row = 0; row < scenario.world.num_cells(); ++row) {
    const double y = scenario.world.CellCenter(row);
    if (y < -61.0 || y > -60.0) continue;
    scenario.world.surface.row(row) = 8.0f;
    scenario.world.cover.row(row) = static_cast<uint8_t>(Cover::kHouse);
  }
  const Truth truth(scenario);
  CHECK(CountFalseSafe(scenario, truth, truth.run) == 0);
  CHECK(CountFalseSafe(scenario, truth, Blind(scenario, truth, Blinding::kFlat)) > 0);
}

TEST_CASE("blinding: doubled heights make landings by absolute heights miss the disc") {
  Scenario scenario = NarrowMeadow();
  // The whole west is lower: the strip lies 4 m above the median.
  scenario.world.ground.setTo(4.0f);
  scenario.world.ground.colRange(0, scenario.world.num_cells() / 2 - 40).setTo(0.0f);
  scenario.world.ground.colRange(scenario.world.num_cells() / 2 + 40, scenario.world.num_cells())
      .setTo(0.0f);
  scenario.world.surface = scenario.world.ground.clone();
  const Truth truth(scenario);
  const EngineRun blinded = Blind(scenario, truth, Blinding::kHeights);
  const auto flights_of = [&](const EngineRun& run) {
    AbsoluteFlights flights;
    for (const Site& site : run.evaluation.sites) {
      if (site.plan.verdict == Verdict::kRejected) continue;
      flights = FlySite(scenario.world, truth.map, scenario.aircraft, site, 1).absolute;
    }
    return flights;
  };
  const AbsoluteFlights before = flights_of(truth.run), after = flights_of(blinded);
  CHECK(before.num_long == 0);
  CHECK(before.num_failed < 20);
  CHECK(after.num_long + after.num_failed == 200);
}

TEST_CASE("blinding: the run's own map stays as it was") {
  const Scenario scenario = NarrowMeadow();
  const Truth truth(scenario);
  const cv::Mat1b hazard = truth.run.evaluation.hazards.hazard.clone();
  const cv::Mat1f upper = truth.run.evaluation.map.upper.clone();
  for (const std::string& name : BlindingNames()) {
    Blinded(truth.run.evaluation.map, truth.run.evaluation.hazards, BlindingNamed(name).value());
  }
  CHECK(cv::norm(hazard, truth.run.evaluation.hazards.hazard, cv::NORM_INF) == 0.0);
  CHECK(cv::norm(upper, truth.run.evaluation.map.upper, cv::NORM_INF) == 0.0);
  CHECK_FALSE(BlindingNamed("nothing"));
}

TEST_CASE("decoys: the largest pieces of other ground, none of them meadow") {
  Scenario scenario = NarrowMeadow();
  const TruthMap truth = MakeTruthMap(scenario.world, scenario.aircraft);
  const std::vector<Region> decoys = LargestDecoys(scenario, truth, 10, 5);
  REQUIRE(decoys.size() == 2);
  CHECK(decoys[0].id == 5);
  CHECK(decoys[1].id == 6);
  for (const Region& decoy : decoys) {
    CHECK(decoy.area_m2 == doctest::Approx(kSizeM * 0.5 * (kSizeM - kStripWidthM)).epsilon(0.01));
    CHECK_FALSE(Contains(decoy.Footprint(), Eigen::Vector2d(0.0, 0.0)));
  }
  CHECK(LargestDecoys(scenario, truth, 1, 1).size() == 1);
  // What no photograph shows is no decoy.
  scenario.seen = cv::Mat1b(scenario.seen.size(), uint8_t{0});
  CHECK(LargestDecoys(scenario, truth, 10, 1).empty());
}

}  // namespace
}  // namespace freelsd
