// Same seed and flight, same bytes: with one thread and two, twice; and nothing false safe in a
// small world.
#include <doctest/doctest.h>

#include "tests/evaluation/world_record.h"

namespace freelsd {
namespace {

// Everything that the engine answered and knew; not what it cost.
nlohmann::json AnswersOf(const Scenario& scenario,
                         const GroundModel& ground_model,
                         const TruthMap& truth,
                         const Fields& fields,
                         int num_threads) {
  cv::setNumThreads(num_threads);
  PipelineOptions options;
  options.regions.min_area_m2 = scenario.aircraft.min_area_m2;
  options.adjustment.num_threads = num_threads;
  const EngineRun run = RunEngine({scenario.rig, scenario.frames, scenario.aircraft},
                                  options,
                                  ground_model,
                                  [](double, const std::string&) { return true; });
  const nlohmann::json record = WorldRecord(1, scenario, run, truth, fields, options);
  return {{"sites", record.at("sites")},
          {"fields", record.at("fields")},
          {"things", record.at("things")},
          {"regions", record.at("regions")},
          {"maps", record.at("maps")},
          {"poses", record.at("poses")}};
}

TEST_CASE("evaluation: one thread or two, the same bytes, and nothing false safe") {
  constexpr uint64_t kSeed = 1001;
  ScenarioOptions small;
  small.world_size_m = 220.0;
  small.cell_size_m = 0.5;
  small.num_frames = 6;
  small.aircraft = "small";
  const Scenario scenario = MakeScenario(kSeed, small, [](double) {});
  const TruthMap truth = MakeTruthMap(scenario.world, scenario.aircraft);
  const Fields fields = FindFields(scenario.world, truth, scenario.aircraft, scenario.seen);
  const GroundModel ground_model =
      ReadGroundModel(FREELSD_SOURCE_DIR "/engine/ground_kind/ground_kind.onnx").model;
  const nlohmann::json once = AnswersOf(scenario, ground_model, truth, fields, 1);
  CHECK(AnswersOf(scenario, ground_model, truth, fields, 2).dump() == once.dump());
  CHECK(once.at("poses").at("num_connected").get<int>() >= 5);
  CHECK(!once.at("regions").empty());
  for (const nlohmann::json& site : once.at("sites")) CHECK(!site.at("is_false_safe"));
}

TEST_CASE("evaluation: same seed, same photographs but for the damaged ones") {
  ScenarioOptions options;
  options.world_size_m = 200.0;
  options.cell_size_m = 0.5;
  options.num_frames = 3;
  const Scenario plain = MakeScenario(1002, options, [](double) {});
  options.damaged_ratio = 1.0;
  const Scenario damaged = MakeScenario(1002, options, [](double) {});
  int num_damaged = 0;
  for (size_t i = 0; i < plain.frames.size(); ++i) {
    const double change = cv::norm(plain.frames[i].image, damaged.frames[i].image, cv::NORM_INF);
    num_damaged += change > 0.0;
    CHECK(damaged.exposures[i].reported.position_in_world ==
          plain.exposures[i].reported.position_in_world);
  }
  // All but the first, which has none before it.
  CHECK(num_damaged == 2);
}

}  // namespace
}  // namespace freelsd
