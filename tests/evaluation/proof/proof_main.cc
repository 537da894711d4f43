// freelsd-proof: makes random free cells of seeded worlds again from the photographs that their
// provenance names, and without the most weighty one.
#include <algorithm>
#include <exception>
#include <iostream>
#include <random>

#include <CLI/CLI.hpp>

#include "tests/evaluation/proof/cell_proof.h"
#include "tests/evaluation/runs/runs.h"
#include "tests/evaluation/synthetic_flight.h"

namespace freelsd {
namespace {

struct Arguments {
  uint64_t seed = 1000;
  int num_worlds = 2;
  int num_cells = 50;
  ScenarioOptions scenario;
  ProvenanceOptions provenance;
};

std::vector<cv::Point> FreeCells(const HazardLayers& hazards) {
  std::vector<cv::Point> cells;
  for (int row = 0; row < hazards.hazard.rows; ++row) {
    for (int col = 0; col < hazards.hazard.cols; ++col) {
      if (hazards.hazard(row, col) == kFree) cells.emplace_back(col, row);
    }
  }
  return cells;
}

std::string Joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text.empty() ? "nothing" : text;
}

// Cells proved, of them the same again, of them the same but for the distance to the nearest
// hazard, and those that change without the most weighty photograph.
struct Counts {
  int num_cells = 0;
  int num_same = 0;
  int num_same_but_distance = 0;
  int num_changed_without = 0;
  size_t num_sources = 0;
  size_t num_context = 0;
  std::map<std::string, int> changed;
};

void Count(const CellProof& proof, Counts& counts) {
  ++counts.num_cells;
  counts.num_same += proof.changed.empty();
  counts.num_same_but_distance += std::all_of(proof.changed.begin(),
                                              proof.changed.end(),
                                              [](const auto& name) { return name == "distance"; });
  counts.num_changed_without += !proof.changed_without.empty();
  counts.num_sources += proof.num_sources;
  counts.num_context += proof.num_context;
  for (const std::string& name : proof.changed) ++counts.changed[name];
}

void ProveWorld(const Arguments& arguments,
                uint64_t seed,
                const Classifier& classifier,
                Counts& counts) {
  const Scenario scenario = MakeScenario(seed, arguments.scenario, [](double) {});
  const PipelineOptions options;
  const EngineRun run = RunEngine({scenario.rig, scenario.frames, scenario.aircraft},
                                  options,
                                  classifier,
                                  [](double, const std::string&) { return true; });
  std::map<std::string, cv::Mat> images;
  for (const Frame& frame : scenario.frames) images[frame.id] = frame.image;
  const ImageSource source = [&images](const std::string& id) { return images.at(id); };
  CellProver prover(run, scenario.aircraft, options, source);
  std::vector<cv::Point> cells = FreeCells(run.evaluation.hazards);
  std::mt19937 random(static_cast<uint32_t>(seed));
  std::shuffle(cells.begin(), cells.end(), random);
  cells.resize(std::min(cells.size(), static_cast<size_t>(arguments.num_cells)));
  for (const cv::Point& cell : cells) {
    const CellProof proof = prover.Prove(cell, arguments.provenance);
    Count(proof, counts);
    if (proof.changed.empty() && !proof.changed_without.empty()) continue;
    std::cout << "world " << seed << ", cell " << cell << ", " << proof.num_sources << " + "
              << proof.num_context << " photographs: changed by them " << Joined(proof.changed)
              << "; without the most weighty " << Joined(proof.changed_without) << "\n";
  }
  std::cout << "world " << seed << ": " << counts.num_cells << " cells so far, " << counts.num_same
            << " the same again, " << counts.num_changed_without << " change without\n"
            << std::flush;
}

// Status 3 where a cell is not the same again, or does not change.
int Run(const Arguments& arguments) {
  const Classifier classifier = Classifier::Parse(ReadTextFile(ModelFileFor({})));
  Counts counts;
  for (int i = 0; i < arguments.num_worlds; ++i) {
    ProveWorld(arguments, arguments.seed + static_cast<uint64_t>(i), classifier, counts);
  }
  const double num = std::max(1, counts.num_cells);
  std::cout << "free cells " << counts.num_cells << ", the same again " << counts.num_same
            << ", the same but for the distance " << counts.num_same_but_distance
            << ", changed without the most weighty photograph " << counts.num_changed_without
            << "\nphotographs named on average: that show the cell "
            << static_cast<double>(counts.num_sources) / num << ", of its context "
            << static_cast<double>(counts.num_context) / num << "\nlayers that changed:";
  for (const auto& [name, count] : counts.changed) std::cout << " " << name << " " << count << ";";
  std::cout << "\n";
  const bool is_right =
      counts.num_same == counts.num_cells && counts.num_changed_without == counts.num_cells;
  return is_right ? 0 : 3;
}

}  // namespace
}  // namespace freelsd

int main(int argc, char** argv) {
  try {
    freelsd::Arguments arguments;
    arguments.scenario.aircraft = "small";
    CLI::App app(
        "Proves free cells of seeded worlds from the photographs that are named for them.");
    app.add_option("--worlds", arguments.num_worlds, "number of worlds")
        ->check(CLI::Range(1, 1000));
    app.add_option("--seed", arguments.seed, "seed of the first world; the others follow");
    app.add_option("--cells", arguments.num_cells, "free cells of each world, at random")
        ->check(CLI::Range(1, 10000));
    app.add_option("--context", arguments.provenance.context_m, "metres around a cell")
        ->check(CLI::Range(1.0, 500.0));
    app.add_option("--texture", arguments.scenario.texture, "painted or recorded")
        ->check(CLI::IsMember({"painted", "recorded"}));
    app.add_option("--conditions", arguments.scenario.conditions, "plain or recorded")
        ->check(CLI::IsMember({"plain", "recorded"}));
    CLI11_PARSE(app, argc, argv);
    return freelsd::Run(arguments);
  } catch (const std::exception& error) {
    std::cerr << "freelsd-proof: " << error.what() << "\n";
    return 1;
  }
}
