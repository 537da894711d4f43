#include "engine/risk/risk.h"

#include <cmath>
#include <stdexcept>

#include <doctest/doctest.h>

#include "tests/engine/approach/scene.h"
#include "tests/engine/refusal.h"

namespace freelsd {
namespace {

constexpr double kPositionSdM = 1.0;

// Lands northwards in the middle of the scene.
PlannedLanding Northwards() {
  return {.approach_distance = 170.0,
          .approach_height = 12.0,
          .ground_speed = 13.0,
          .wind_spread_mps = 0.5,
          .position_sd_m = kPositionSdM,
          .loiter_center_in_world = {60.0, -170.0},
          .loiter_radius = 60.0};
}

scene::Scene FlatMeadow() {
  scene::Scene meadow = scene::Meadow(500, 300, 1.0, [](const Eigen::Vector2d&) { return 0.0; });
  meadow.map.standard_deviation.setTo(0.1f);
  return meadow;
}

double RiskOn(const scene::Scene& scene, const PlannedLanding& landing = Northwards()) {
  return RiskAssessor(scene.map, scene.hazards, Aircraft{}, RiskOptions{})
      .FailureProbability(landing);
}

// A square of 4 m around a place east and north of the touchdown.
cv::Rect SquareAt(const scene::Scene& scene, double east, double north) {
  const cv::Point cell = *scene.map.grid.CellAt({east, north});
  return {cell.x - 2, cell.y - 2, 4, 4};
}

void PutOtherKind(scene::Scene& scene, const cv::Rect& cells) {
  scene.hazards.grass(cells) = 0.0f;
  scene.hazards.hazard(cells) = uint8_t{kHazard};
}

void PutThing(scene::Scene& scene, const cv::Rect& cells, float height_m) {
  scene.map.upper(cells) = height_m;
  scene.hazards.hazard(cells) = uint8_t{kHazard};
}

TEST_CASE("risk: a flat sure meadow has hardly any") { CHECK(RiskOn(FlatMeadow()) < 0.005); }

TEST_CASE("risk: ground of another kind below the whole roll makes failure certain") {
  scene::Scene scene = FlatMeadow();
  PutOtherKind(scene, {100, 150, 100, 140});
  CHECK(RiskOn(scene) > 0.99);
}

TEST_CASE("risk: a spot beside the strip counts with the chance that a roll reaches it") {
  scene::Scene beside = FlatMeadow(), within = FlatMeadow(), away = FlatMeadow();
  PutThing(within, SquareAt(within, 0.0, 20.0), 2.0f);
  PutThing(beside, SquareAt(beside, 11.0, 20.0), 2.0f);
  PutThing(away, SquareAt(away, 25.0, 20.0), 2.0f);
  CHECK(RiskOn(within) > 0.7);
  CHECK(RiskOn(beside) > 0.02);
  CHECK(RiskOn(beside) < 0.5);
  CHECK(RiskOn(away) < 0.005);
}

TEST_CASE("risk: a thing on the final counts if it reaches up to the path") {
  // The path is 7 m high there.
  scene::Scene low = FlatMeadow(), high = FlatMeadow();
  PutThing(low, SquareAt(low, 0.0, -100.0), 4.0f);
  PutThing(high, SquareAt(high, 0.0, -100.0), 9.0f);
  CHECK(RiskOn(low) < 0.02);
  CHECK(RiskOn(high) > 0.8);
}

TEST_CASE("risk: coming down early on fit ground is a landing") {
  // 2 m above the path from 10 m to 30 m before touchdown: a bank of meadow.
  scene::Scene bank = FlatMeadow();
  const cv::Rect cells(100, 260, 100, 20);
  bank.map.elevation(cells) = 2.0f;
  bank.map.upper(cells) = 2.0f;
  CHECK(RiskOn(bank) < 0.01);
  PutOtherKind(bank, cells);
  CHECK(RiskOn(bank) > 0.9);
}

TEST_CASE("risk: the doubt about a field counts once, however many cells share it") {
  scene::Scene doubtful = FlatMeadow();
  doubtful.hazards.grass.setTo(0.9f);
  CHECK(RiskOn(doubtful) == doctest::Approx(0.1).epsilon(0.05));
}

TEST_CASE("risk: a thing below the circle counts there alone") {
  scene::Scene scene = FlatMeadow();
  PutThing(scene, SquareAt(scene, 120.0, -170.0), 14.0f);
  const LandingRisk risk =
      RiskAssessor(scene.map, scene.hazards, Aircraft{}, RiskOptions{}).Assess(Northwards());
  CHECK(risk.parts.circle > 0.9);
  CHECK(risk.parts.ground < 0.005);
  CHECK(risk.parts.final_path < 0.005);
  CHECK(risk.failure_probability > 0.9);
}

TEST_CASE("risk: what the map's position adds is told") {
  // The strip itself is free. With an exact map only the scatter of the touchdown reaches the edge.
  scene::Scene lane = FlatMeadow();
  PutOtherKind(lane, {0, 0, 134, 500});
  PutOtherKind(lane, {167, 0, 133, 500});
  PlannedLanding shaky = Northwards();
  shaky.position_sd_m = 4.0;
  const RiskAssessor assessor(lane.map, lane.hazards, Aircraft{}, RiskOptions{});
  CHECK(assessor.Assess(shaky).parts.position > 0.02);
  CHECK(assessor.Assess(shaky).failure_probability >
        assessor.Assess(Northwards()).failure_probability);
}

TEST_CASE("risk: without a known position of the map failure is certain") {
  PlannedLanding unknown = Northwards();
  unknown.position_sd_m = std::nan("");
  CHECK(RiskOn(FlatMeadow(), unknown) == 1.0);
}

TEST_CASE("risk: the probability of an unfit shape grows with it and never reaches certainty") {
  double last = 0.0;
  for (double ratio = 0.0; ratio < 3.0; ratio += 0.05) {
    CHECK(RiskOfShape(ratio) >= last);
    last = RiskOfShape(ratio);
  }
  CHECK(last < 1.0);
  CHECK(RiskOfShape(std::nan("")) == 1.0);
}

TEST_CASE("risk: both ways to ask give the same probability, every time") {
  scene::Scene scene = FlatMeadow();
  PutThing(scene, SquareAt(scene, 8.0, 10.0), 2.0f);
  const RiskAssessor assessor(scene.map, scene.hazards, Aircraft{}, RiskOptions{});
  CHECK(assessor.FailureProbability(Northwards()) ==
        assessor.Assess(Northwards()).failure_probability);
  CHECK(RiskOn(scene) == assessor.FailureProbability(Northwards()));
}

TEST_CASE("risk: options outside their range are refused by name") {
  CHECK(IsRefused(&RiskOptions::num_risk_flights, 0, "approach.num_risk_flights"));
  CHECK(IsRefused(&RiskOptions::error_length_m, 0.0, "approach.error_length_m"));
  CHECK(IsRefused(&RiskOptions::unmeasured_wind_sd_mps, -1.0, "approach.unmeasured_wind_sd_mps"));
}

}  // namespace
}  // namespace freelsd
