#include "tests/evaluation/scores/field_scores.h"

#include <doctest/doctest.h>

#include "tests/evaluation/truth_run.h"

namespace freelsd {
namespace {

// A meadow with one field; the flight saw `seen_to_east`, in metres from the middle, and all west
// of it. Wind blows east.
struct MeadowFlight {
  Scenario scenario;
  TruthMap truth;
  Fields fields;

  explicit MeadowFlight(double seen_to_east = 1000.0) {
    WorldOptions options;
    options.size_m = 300.0;
    options.cell_size_m = 0.5;
    scenario.world = MakeMeadowPlane(options);
    scenario.aircraft = AircraftProfile("small").value();
    truth = MakeTruthMap(scenario.world, scenario.aircraft);
    scenario.seen = cv::Mat1b(truth.fault.size(), uint8_t{0});
    for (int col = 0; col < truth.fault.cols; ++col) {
      if (truth.CellCenter(0, col).x() < seen_to_east) scenario.seen.col(col) = uint8_t{255};
    }
    fields = FindFields(scenario.world, truth, scenario.aircraft, scenario.seen);
    REQUIRE(fields.fields.size() == 1);
  }
  FieldScore ScoreOf(const EngineRun& run) const {
    return ScoreFields(scenario, run, truth, fields, PipelineOptions{}).at(0);
  }
  EngineRun RunWithoutError() const {
    return RunOnTruth(scenario, truth, fields, ApproachOptions{});
  }
};

TEST_CASE(
    "field scores: the planner's own site on maps without error is found and not false safe") {
  const MeadowFlight flight;
  const FieldScore score = flight.ScoreOf(flight.RunWithoutError());
  CHECK(score.is_found);
  CHECK(score.is_accepted_on_truth);
  CHECK(score.reason_on_truth == "");
  CHECK(score.fault_on_truth == "");
  CHECK(score.photographed_ratio == 1.0);
  CHECK(score.lost_reason == "");
}

TEST_CASE("field scores: a field that nobody asked for is accepted if asked") {
  const MeadowFlight flight;
  EngineRun run = flight.RunWithoutError();
  run.evaluation.sites.clear();
  const FieldScore score = flight.ScoreOf(run);
  CHECK_FALSE(score.is_found);
  CHECK(score.lost_reason == "accepted if asked");
}

TEST_CASE("field scores: a lost field has the rule that fails on the engine's map") {
  const MeadowFlight flight;
  EngineRun run = flight.RunWithoutError();
  run.evaluation.sites.clear();
  EngineRun hazardous = run;
  hazardous.evaluation.hazards.distance = cv::Mat1f(run.evaluation.map.elevation.size(), 0.0f);
  CHECK(flight.ScoreOf(hazardous).lost_reason == "hazard_distance");
  // A wall that the map alone has, over all of the east.
  EngineRun walled = run;
  walled.evaluation.map.upper = run.evaluation.map.upper.clone();
  const FieldScore score = flight.ScoreOf(run);
  const cv::Point cell = run.evaluation.map.grid.CellAt(score.touchdown).value();
  walled.evaluation.map.upper.col(cell.x + 20) = 30.0f;
  walled.evaluation.hazards.hazard = run.evaluation.hazards.hazard.clone();
  walled.evaluation.hazards.hazard.col(cell.x + 20) = uint8_t{kHazard};
  CHECK(flight.ScoreOf(walled).lost_reason == "final");
  CHECK(flight.ScoreOf(EngineRun{}).lost_reason == "no map");
}

TEST_CASE("field scores: what was not photographed is told by its share and by the planner") {
  // All touchdowns of the west have their final over the unseen east.
  const MeadowFlight flight(-130.0);
  const FieldScore score = flight.ScoreOf(EngineRun{});
  CHECK_FALSE(score.is_accepted_on_truth);
  CHECK(score.reason_on_truth != "");
  CHECK(score.photographed_ratio < 0.5);
  // Half of it: the planner's own place is photographed wholly.
  const MeadowFlight half(50.0);
  CHECK(half.ScoreOf(EngineRun{}).is_accepted_on_truth);
  CHECK(half.ScoreOf(EngineRun{}).photographed_ratio > 0.99);
}

}  // namespace
}  // namespace freelsd
