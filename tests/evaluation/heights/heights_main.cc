// freelsd-heights: heights by pairs beside heights by all photographs, over seeded worlds.
#include <cstdio>
#include <exception>
#include <iostream>

#include <CLI/CLI.hpp>

#include "tests/evaluation/heights/height_run.h"
#include "tests/evaluation/heights/height_table.h"
#include "tests/evaluation/runs/runs.h"

namespace freelsd {
namespace {

struct Arguments {
  ScenarioOptions scenario;
  uint64_t seed = 1000;
  int num_worlds = 1;
  // After those, with textures, light, air and camera as recorded.
  int num_recorded_worlds = 0;
  bool makes_table = false;
  std::string model = FREELSD_SOURCE_DIR "/engine/classification/grass_model.yml";
};

using Results = std::map<HeightMethod, MethodResult>;

double Share(int64_t part, int64_t whole) {
  return whole == 0 ? 0.0 : 100.0 * static_cast<double>(part) / static_cast<double>(whole);
}

template <typename Value>
void PrintRow(const std::string& name, const Results& results, Value value) {
  std::printf("%-44s", name.c_str());
  for (const HeightMethod method : {HeightMethod::kPairs, HeightMethod::kPhotographs}) {
    std::printf("%16.3f", value(results.at(method)));
  }
  std::printf("\n");
}

void PrintThings(const std::string& group, const Results& results) {
  std::printf("%-44s", group.c_str());
  for (const HeightMethod method : {HeightMethod::kPairs, HeightMethod::kPhotographs}) {
    const auto& things = results.at(method).score.things;
    const auto counts =
        things.contains(group) ? things.at(group) : std::array<int64_t, kNumThingFates>{};
    const int64_t all = counts[0] + counts[1] + counts[2] + counts[3];
    std::printf("   %4ld %4ld %4ld %4ld %5.1f%%",
                static_cast<long>(counts[0]),
                static_cast<long>(counts[1]),
                static_cast<long>(counts[2]),
                static_cast<long>(counts[3]),
                Share(counts[0] + counts[1], all));
  }
  std::printf("\n");
}

void Print(const Results& results) {
  std::printf("%-44s%16s%16s\n", "", "pairs", "photographs");
  PrintRow("noise of open ground, median of windows, m", results, [](const MethodResult& each) {
    return each.score.open.local_noise.Percentile(50.0);
  });
  PrintRow("noise of open ground, 90th percentile, m", results, [](const MethodResult& each) {
    return each.score.open.local_noise.Percentile(90.0);
  });
  PrintRow("error in stated deviations, RMS", results, [](const MethodResult& each) {
    return each.score.open.error_in_deviations.Rms();
  });
  PrintRow("open ground said to be unknown, %", results, [](const MethodResult& each) {
    return Share(each.score.open.num_unknown, each.score.open.num_cells);
  });
  PrintRow("known open ground raised by 0.5 m, %", results, [](const MethodResult& each) {
    return Share(each.score.open.num_raised,
                 each.score.open.num_cells - each.score.open.num_unknown);
  });
  PrintRow("sites accepted", results, [](const MethodResult& each) {
    return static_cast<double>(each.num_accepted);
  });
  PrintRow("  of these false safe", results, [](const MethodResult& each) {
    return static_cast<double>(each.num_false_safe);
  });
  PrintRow("engine, s/ha", results, [](const MethodResult& each) {
    return each.total_seconds / each.hectares;
  });
  for (const auto& [stage, seconds] : results.at(HeightMethod::kPhotographs).seconds) {
    PrintRow("  " + stage + ", s/ha", results, [&stage = stage](const MethodResult& each) {
      const auto found = each.seconds.find(stage);
      return found == each.seconds.end() ? 0.0 : found->second / each.hectares;
    });
  }
  std::printf("things: found, unknown, only hazard, missed; found or unknown\n");
  std::map<std::string, int> groups;
  for (const auto& [method, result] : results) {
    for (const auto& [group, counts] : result.score.things) groups[group] = 1;
  }
  for (const auto& [group, one] : groups) PrintThings(group, results);
}

ScenarioOptions ScenarioOf(const Arguments& arguments, int world) {
  ScenarioOptions scenario = arguments.scenario;
  if (world < arguments.num_worlds) return scenario;
  scenario.texture = "recorded";
  scenario.conditions = "recorded";
  scenario.cell_size_m = 0.1;  // recorded textures are that fine
  return scenario;
}

int Run(const Arguments& arguments) {
  const Classifier classifier = Classifier::Parse(ReadTextFile(arguments.model));
  cv::setNumThreads(1);
  Results all;
  HeightTable table;
  for (int i = 0; i < arguments.num_worlds + arguments.num_recorded_worlds; ++i) {
    const uint64_t seed = arguments.seed + static_cast<uint64_t>(i);
    const HeightRun run = RunHeights(seed, ScenarioOf(arguments, i), PipelineOptions{}, classifier);
    for (const auto& [method, result] : run.results) all[method].Add(result);
    if (arguments.makes_table) table.Add(run.scenario, run.truth, run.heights, run.offset);
    std::cerr << "seed " << seed << " done\n";
  }
  Print(all);
  if (arguments.makes_table) std::cout << table.Text();
  return 0;
}

void AddOptions(CLI::App& app, Arguments& arguments) {
  ScenarioOptions& scenario = arguments.scenario;
  app.add_option("--seed", arguments.seed, "seed of the first world; the others follow")
      ->check(CLI::Range(0, 8999));
  app.add_option("--worlds", arguments.num_worlds, "number of worlds")->check(CLI::Range(0, 1000));
  app.add_option("--recorded-worlds",
                 arguments.num_recorded_worlds,
                 "further worlds: recorded textures and conditions, cells of 0.1 m")
      ->check(CLI::Range(0, 1000));
  app.add_option("--frames", scenario.num_frames, "photographs per world")
      ->check(CLI::Range(3, 300));
  app.add_option("--texture", scenario.texture, "painted, or recorded on photographs")
      ->check(CLI::IsMember({"painted", "recorded"}));
  app.add_option("--conditions", scenario.conditions, "light, air and camera: plain, or recorded")
      ->check(CLI::IsMember({"plain", "recorded"}));
  app.add_option("--cell", scenario.cell_size_m, "texture of a world in metres")
      ->check(CLI::Range(0.1, 1.0));
  app.add_option("--noise", scenario.noise_scale, "scale of the autopilot's errors")
      ->check(CLI::Range(0.0, 10.0));
  app.add_flag(
      "--table", arguments.makes_table, "print the table of engine/heights/likelihood_table.h");
  app.add_option("--model", arguments.model, "grass classifier");
}

}  // namespace
}  // namespace freelsd

int main(int argc, char** argv) {
  try {
    freelsd::Arguments arguments;
    CLI::App app("Compares heights by pairs with heights by all photographs, on tuning worlds.");
    freelsd::AddOptions(app, arguments);
    CLI11_PARSE(app, argc, argv);
    return freelsd::Run(arguments);
  } catch (const std::exception& error) {
    std::cerr << "freelsd-heights: " << error.what() << "\n";
    return 1;
  }
}
