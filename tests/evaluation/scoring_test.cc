// The evaluator, judged: answers that are wrong on purpose must be reported as false safe.
#include <cmath>

#include <doctest/doctest.h>

#include "tests/evaluation/report.h"
#include "tests/evaluation/site_score.h"
#include "tests/evaluation/statistics.h"
#include "tests/evaluation/truth_run.h"
#include "tests/evaluation/world_record.h"

namespace freelsd {
namespace {

constexpr double kFinalM = 60.0;
constexpr double kCircleM = 40.0;

const Eigen::Vector2d kTree(40.0, 0.0);

// A meadow with a house 40 m north and a tree 40 m east of the middle; wind blows east.
World MeadowWithHouseAndTree() {
  WorldOptions options;
  options.size_m = 300.0;
  options.cell_size_m = 0.5;
  World world = MakeMeadowPlane(options);
  world.Build({.center = {0.0, 40.0}});
  world.Plant(Tree{.center = kTree});
  return world;
}

// Into the wind, to that place; the circle lies south of the final.
Plan PlanTo(const Eigen::Vector2d& touchdown, Verdict verdict) {
  Plan plan;
  plan.verdict = verdict;
  plan.touchdown_in_world << touchdown, 0.0;
  Approach approach;
  approach.touchdown_in_world = plan.touchdown_in_world;
  approach.approach_start_in_world << touchdown + Eigen::Vector2d(kFinalM, 0.0), 10.0;
  approach.heading = 1.5 * kPi;
  approach.approach_distance = kFinalM;
  approach.approach_height = 10.0;
  approach.loiter_radius = kCircleM;
  approach.loiter_center_in_world << touchdown + Eigen::Vector2d(kFinalM, -kCircleM), 10.0;
  plan.approach = approach;
  return plan;
}

const Eigen::Vector2d kGoodPlace(0.0, -40.0);
const Eigen::Vector2d kRoof(0.0, 40.0);
const Eigen::Vector2d kBehindTree(10.0, 0.0);

SafetyScore ScoreOf(const World& world, const Plan& plan, const Eigen::Vector2d& shift) {
  const Aircraft aircraft = AircraftProfile("small").value();
  return ScorePlan(world, MakeTruthMap(world, aircraft), aircraft, plan, shift).value();
}

SafetyScore ScoreOf(const World& world, const Plan& plan) {
  return ScoreOf(world, plan, Eigen::Vector2d::Zero());
}

// The totals of a flight over that world in which the engine gave this one answer.
nlohmann::json SafetyOf(const World& world, const Plan& plan) {
  Scenario scenario;
  scenario.world = world;
  scenario.aircraft = AircraftProfile("small").value();
  const TruthMap truth = MakeTruthMap(world, scenario.aircraft);
  scenario.seen = cv::Mat1b(truth.fault.size(), static_cast<uint8_t>(255));
  EngineRun run;
  Site site;
  site.plan = plan;
  run.evaluation.sites.push_back(site);
  const Fields fields = FindFields(world, truth, scenario.aircraft, scenario.seen);
  const nlohmann::json record = WorldRecord(1, scenario, run, truth, fields, PipelineOptions{});
  return MakeReport(nlohmann::json::object(), nlohmann::json::array({record})).at("safety");
}

TEST_CASE("scoring: a good answer is not false safe, and its field is found") {
  const World world = MeadowWithHouseAndTree();
  const Plan plan = PlanTo(kGoodPlace, Verdict::kLandable);
  CHECK_FALSE(ScoreOf(world, plan).IsFalseSafe(plan.verdict));
  const nlohmann::json safety = SafetyOf(world, plan);
  CHECK(safety.at("num_landable_sites") == 1);
  CHECK(safety.at("num_false_safe") == 0);
  CHECK(safety.at("num_fields") == 1);
  CHECK(safety.at("num_fields_found") == 1);
}

TEST_CASE("scoring: a touchdown on a roof is reported as false safe") {
  const World world = MeadowWithHouseAndTree();
  for (const Verdict verdict : {Verdict::kLandable, Verdict::kUnverified}) {
    const Plan plan = PlanTo(kRoof, verdict);
    const SafetyScore score = ScoreOf(world, plan);
    CHECK(score.ground_fault == "house");
    CHECK(score.free_distance == 0.0);
    CHECK(score.IsFalseSafe(verdict));
    CHECK(SafetyOf(world, plan).at("num_false_safe") == 1);
  }
  const Plan refused = PlanTo(kRoof, Verdict::kRejected);
  CHECK_FALSE(ScoreOf(world, refused).IsFalseSafe(refused.verdict));
  CHECK(SafetyOf(world, refused).at("num_false_safe") == 0);
}

TEST_CASE("scoring: a final through a tree is reported as false safe") {
  const World world = MeadowWithHouseAndTree();
  const Plan plan = PlanTo(kBehindTree, Verdict::kUnverified);
  const SafetyScore score = ScoreOf(world, plan);
  CHECK(score.ground_fault == "");
  CHECK(score.final_fault == "tree");
  CHECK(score.final_clearance < -2.0);
  CHECK((score.final_worst_place - kTree).norm() < Tree().radius_m);
  CHECK(score.IsFalseSafe(plan.verdict));
  const nlohmann::json safety = SafetyOf(world, plan);
  CHECK(safety.at("num_false_safe") == 1);
  CHECK(safety.at("false_safe_causes").at("final: tree") == 1);
}

TEST_CASE("scoring: a circle through a tree is false safe for a landable site only") {
  World world = MeadowWithHouseAndTree();
  world.Plant(
      Tree{.center = kGoodPlace + Eigen::Vector2d(kFinalM, -2.0 * kCircleM), .height_m = 14.0});
  const SafetyScore score = ScoreOf(world, PlanTo(kGoodPlace, Verdict::kLandable));
  CHECK(score.final_fault == "");
  CHECK(score.loiter_fault == "tree");
  CHECK(score.IsFalseSafe(Verdict::kLandable));
  CHECK_FALSE(score.IsFalseSafe(Verdict::kUnverified));
}

TEST_CASE("scoring: an answer on a shifted map is false safe, and the shift is told as the cause") {
  const World world = MeadowWithHouseAndTree();
  // The engine's map lies 60 m farther north than the world does.
  const Eigen::Vector2d shift(0.0, 60.0);
  const Plan plan = PlanTo(kGoodPlace + Eigen::Vector2d(0.0, 70.0), Verdict::kLandable);
  CHECK(ScoreOf(world, plan).IsFalseSafe(plan.verdict));
  CHECK_FALSE(ScoreOf(world, plan, shift).IsFalseSafe(plan.verdict));
}

TEST_CASE("scoring: a young tree in the touchdown disc counts, however thin") {
  World world = MeadowWithHouseAndTree();
  world.Plant(Tree{.center = kGoodPlace + Eigen::Vector2d(0.0, 7.0), .radius_m = 0.6});
  CHECK(ScoreOf(world, PlanTo(kGoodPlace, Verdict::kLandable)).ground_fault == "tree");
}

TEST_CASE("scoring: fence, pole and wire have a row of their own, and hide nothing") {
  const Eigen::Vector2d side(0.0, 7.0), half(3.0, 0.0);
  const auto safety_of = [](const World& world) {
    return SafetyOf(world, PlanTo(kGoodPlace, Verdict::kUnverified));
  };
  const Fence fence{.start = kGoodPlace + side - half, .end = kGoodPlace + side + half};
  World fenced = MeadowWithHouseAndTree();
  fenced.Build(fence);
  CHECK(safety_of(fenced).at("num_false_safe") == 0);
  CHECK(safety_of(fenced).at("num_false_safe_thin") == 1);
  CHECK(safety_of(fenced).at("thin_causes").at("ground: fence") == 1);
  CHECK(safety_of(fenced).at("num_fields_found") == 1);
  CHECK(safety_of(fenced).at("num_fields_found_safely") == 0);
  World ditch_too = MeadowWithHouseAndTree();
  ditch_too.Dig(Ditch{.start = kGoodPlace - side - half, .end = kGoodPlace - side + half});
  ditch_too.Build(fence);
  CHECK(safety_of(ditch_too).at("num_false_safe") == 1);
  CHECK(safety_of(ditch_too).at("num_false_safe_thin") == 0);
  CHECK(safety_of(ditch_too).at("false_safe_causes").at("ground: ditch") == 1);
  // Over the final, its poles far from it.
  const PowerLine line{.start = kGoodPlace + Eigen::Vector2d(30.0, -60.0),
                       .end = kGoodPlace + Eigen::Vector2d(30.0, 60.0),
                       .height_m = 6.0,
                       .spacing_m = 40.0};
  World wired = MeadowWithHouseAndTree();
  wired.Build(line);
  CHECK(safety_of(wired).at("num_false_safe") == 0);
  CHECK(safety_of(wired).at("thin_causes").at("final: wire") == 1);
  World tree_too = MeadowWithHouseAndTree();
  tree_too.Plant(Tree{.center = kGoodPlace + Eigen::Vector2d(20.0, 0.0), .height_m = 6.0});
  tree_too.Build(line);
  CHECK(safety_of(tree_too).at("false_safe_causes").at("final: tree") == 1);
  CHECK(safety_of(tree_too).at("num_false_safe_thin") == 0);
}

TEST_CASE("scoring: a pole makes what lies around it rough, and is still all that is wrong") {
  World world = MeadowWithHouseAndTree();
  world.Build(PowerLine{.start = kGoodPlace + Eigen::Vector2d(-6.0, -100.0),
                        .end = kGoodPlace + Eigen::Vector2d(-6.0, 100.0),
                        .height_m = 8.0,
                        .spacing_m = 100.0});
  const SafetyScore score = ScoreOf(world, PlanTo(kGoodPlace, Verdict::kUnverified));
  CHECK(score.ground_fault == "pole");
  CHECK(score.IsOnlyThin(Verdict::kUnverified));
}

TEST_CASE("scoring: at the edge of the world nothing is known to be free") {
  const World world = MeadowWithHouseAndTree();
  const Plan plan = PlanTo({0.0, 146.0}, Verdict::kUnverified);
  CHECK(ScoreOf(world, plan).ground_fault == "outside");
  CHECK(SafetyOf(world, plan).at("num_false_safe") == 1);
}

TEST_CASE(
    "scoring: an accepted site without an approach cannot be judged, and is not passed over") {
  const World world = MeadowWithHouseAndTree();
  Plan plan = PlanTo(kGoodPlace, Verdict::kUnverified);
  plan.approach.reset();
  CHECK_THROWS_AS(SafetyOf(world, plan), std::invalid_argument);
  plan.verdict = Verdict::kRejected;
  plan.reject_reason = RejectReason::kNotGrass;
  CHECK_NOTHROW(SafetyOf(world, plan));
}

TEST_CASE("fields: a row of trees makes two of one, and a piece without room is none") {
  WorldOptions options;
  options.size_m = 300.0;
  options.cell_size_m = 0.5;
  World world = MakeMeadowPlane(options);
  world.Plant(Hedge{.start = {-60.0, -150.0}, .end = {-60.0, 150.0}, .height_m = 3.0});
  world.Plant(Hedge{.start = {-75.0, -150.0}, .end = {-75.0, 150.0}, .height_m = 3.0});
  const Aircraft aircraft = AircraftProfile("small").value();
  const TruthMap truth = MakeTruthMap(world, aircraft);
  const cv::Mat1b seen(truth.fault.size(), static_cast<uint8_t>(255));
  const Fields fields = FindFields(world, truth, aircraft, seen);
  CHECK(fields.fields.size() == 2);
  CHECK(fields.label(150, 82) == 0);
  for (const Field& field : fields.fields) {
    CHECK(field.is_landable);
    CHECK(field.free_radius > aircraft.touchdown_uncertainty_m);
  }
  // Nothing was seen: nothing could be found.
  const cv::Mat1b unseen(truth.fault.size(), static_cast<uint8_t>(0));
  for (const Field& field : FindFields(world, truth, aircraft, unseen).fields) {
    CHECK(field.num_touchdowns > 0);
    CHECK(field.num_seen_touchdowns == 0);
  }
}

TEST_CASE("statistics: the 95 % bound of 0 of 600 is 0.5 %, and sums add up") {
  CHECK(UpperBound95(0, 600) == doctest::Approx(0.00498).epsilon(0.01));
  CHECK(UpperBound95(0, 0) == 1.0);
  // 3 of 200, one-sided, Clopper-Pearson.
  CHECK(UpperBound95(3, 200) == doctest::Approx(0.0384).epsilon(0.01));
  Sums all, first, second;
  LogHistogram histogram;
  for (int i = 1; i <= 100; ++i) {
    all.Add(i);
    (i % 3 == 0 ? first : second).Add(i);
    histogram.Add(i);
  }
  first.Add(SumsFromJson(ToJson(second)));
  CHECK(first.Mean() == doctest::Approx(50.5));
  CHECK(first.Sd() == doctest::Approx(all.Sd()));
  CHECK(LogHistogram::FromJson(histogram.ToJson()).Percentile(95.0) ==
        doctest::Approx(95.0).epsilon(0.05));
  RocCounts roc;
  for (const double p : {0.9, 0.8, 0.4}) roc.Add(p, true);
  for (const double p : {0.6, 0.2, 0.1}) roc.Add(p, false);
  CHECK(roc.Auc() == doctest::Approx(8.0 / 9.0));
  CHECK(roc.ErrorRatio() == doctest::Approx(2.0 / 6.0));
}

TEST_CASE("evaluation: on maps without error fields are found, and no answer is false safe") {
  ScenarioOptions options;
  options.takes_photographs = false;
  int num_accepted = 0;
  for (const uint64_t seed : {1030, 1034}) {
    const Scenario scenario = MakeScenario(seed, options, [](double) {});
    CHECK(scenario.frames.empty());
    const TruthMap truth = MakeTruthMap(scenario.world, scenario.aircraft);
    const Fields fields = FindFields(scenario.world, truth, scenario.aircraft, scenario.seen);
    const EngineRun run = RunOnTruth(scenario, truth, fields, ApproachOptions{});
    REQUIRE(run.evaluation.sites.size() == fields.fields.size());
    for (const Site& site : run.evaluation.sites) {
      if (site.plan.verdict == Verdict::kRejected) continue;
      ++num_accepted;
      const auto score =
          ScorePlan(scenario.world, truth, scenario.aircraft, site.plan, Eigen::Vector2d::Zero());
      REQUIRE(score);
      CHECK_FALSE(score->IsFalseSafe(site.plan.verdict));
      const cv::Point cell = truth.CellAt(site.plan.touchdown_in_world.head<2>());
      CHECK(fields.label(cell) == site.region.id);
    }
  }
  CHECK(num_accepted >= 5);
}

}  // namespace
}  // namespace freelsd
