// freelsd-watch: watches stored strips in later passes over seeded worlds; tables of what it told.
#include <cctype>
#include <cstdio>
#include <exception>
#include <iostream>

#include <CLI/CLI.hpp>

#include "tests/evaluation/runs/runs.h"
#include "tests/evaluation/watch/recorded_watch.h"
#include "tests/evaluation/watch/watch_log.h"
#include "tests/evaluation/watch/watch_run.h"

namespace freelsd {
namespace {

struct Arguments {
  WatchRunOptions run;
  uint64_t seed = 1000;
  int num_worlds = 1;
  std::vector<std::string> reported;
  RecordedWatchOptions recorded;
  std::vector<std::string> folders;
  std::string model = FREELSD_SOURCE_DIR "/engine/classification/grass_model.yml";
};

void Fly(const Arguments& arguments) {
  const Classifier classifier = Classifier::Parse(ReadTextFile(arguments.model));
  std::vector<WatchRow> all;
  PoolOfRun pool;
  for (int i = 0; i < arguments.num_worlds; ++i) {
    const uint64_t seed = arguments.seed + static_cast<uint64_t>(i);
    pool.Add("seed " + std::to_string(seed), EvaluationPools().OfSeed(seed));
    const auto rows = WatchWorld(seed, arguments.run, classifier);
    std::fprintf(
        stderr, "world %lu: %zu photographs\n", static_cast<unsigned long>(seed), rows.size());
    all.insert(all.end(), rows.begin(), rows.end());
  }
  std::cout << WatchReport(all);
}

void WatchFlights(const Arguments& arguments) {
  const Classifier classifier = Classifier::Parse(ReadTextFile(arguments.model));
  std::vector<WatchRow> all;
  for (const std::string& folder : arguments.folders) {
    const auto rows = WatchRecorded(folder, arguments.recorded, classifier);
    if (!arguments.run.log.empty()) WriteRows(rows, arguments.run.log);
    all.insert(all.end(), rows.begin(), rows.end());
  }
  std::cout << WatchReport(all);
}

void Report(const Arguments& arguments) {
  std::vector<WatchRow> all;
  PoolOfRun pool;
  for (const std::string& file : arguments.reported) {
    const auto rows = ReadRows(file);
    for (const WatchRow& row : rows) {
      const std::string source = row.pass.substr(0, row.pass.find('-'));
      pool.Add(source + " in " + file,
               std::isdigit(static_cast<unsigned char>(source[0])) != 0
                   ? EvaluationPools().OfSeed(std::stoull(source))
                   : EvaluationPools().Of("flight", source));
    }
    all.insert(all.end(), rows.begin(), rows.end());
  }
  std::cout << WatchReport(all);
}

int Main(int argc, char** argv) {
  Arguments arguments;
  WatchRunOptions& run = arguments.run;
  CLI::App app("Watches stored strips in later passes over seeded worlds");
  app.require_subcommand(1);
  CLI::App* fly = app.add_subcommand("fly", "photographs worlds, stores their sites, watches them");
  fly->add_option("--seed", arguments.seed, "of the first world");
  fly->add_option("--worlds", arguments.num_worlds);
  fly->add_option("--passes", run.num_passes, "later passes over each world");
  fly->add_flag("--events", run.has_events, "something new stands on the strip in every pass");
  fly->add_option("--height", run.scenario.height_m, "of the stored pass, metres");
  fly->add_option("--cell", run.scenario.cell_size_m, "of the world, metres");
  fly->add_option("--texture", run.scenario.texture, "painted or recorded");
  fly->add_option("--conditions", run.scenario.conditions, "plain or recorded");
  fly->add_option("--noise", run.scenario.noise_scale, "multiplies the errors of all poses");
  fly->add_option("--log", run.log, "rows are added to this file, one for each photograph");
  fly->add_option("--pictures", run.pictures, "folder for pictures of misses and false alarms");
  CLI::App* report = app.add_subcommand("report", "tables of logs");
  report->add_option("logs", arguments.reported)->required();
  CLI::App* recorded =
      app.add_subcommand("recorded", "compares the legs of recorded flights with each other");
  recorded->add_option("flights", arguments.folders, "folders of flights")->required();
  recorded->add_option("--spacing", arguments.recorded.spacing_m, "of strips, metres");
  recorded->add_option("--parts", arguments.recorded.num_parts, "of each flight");
  recorded->add_option("--log", run.log, "rows are added to this file");
  recorded->add_option("--pictures", arguments.recorded.pictures, "folder for what was told");
  CLI11_PARSE(app, argc, argv);
  if (*fly) Fly(arguments);
  if (*recorded) WatchFlights(arguments);
  if (*report) Report(arguments);
  return 0;
}

}  // namespace
}  // namespace freelsd

int main(int argc, char** argv) {
  try {
    return freelsd::Main(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
}
