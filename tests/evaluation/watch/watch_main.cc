// freelsd-watch: watches stored strips in later passes over seeded worlds; tables of what it told.
#include <cctype>
#include <exception>
#include <iostream>

#include <CLI/CLI.hpp>

#include "tests/evaluation/runs/runs.h"
#include "tests/evaluation/watch/cue_fit.h"
#include "tests/evaluation/watch/recorded_watch.h"
#include "tests/evaluation/watch/watch_log.h"
#include "tests/evaluation/watch/watch_run.h"

namespace freelsd {
namespace {

struct Arguments {
  PhotographOptions photographed;
  WatchRunOptions run;
  std::vector<std::string> watched;
  uint64_t seed = 1000;
  int num_worlds = 1;
  std::vector<std::string> reported;
  RecordedWatchOptions recorded;
  std::vector<std::string> folders;
  std::string model = FREELSD_SOURCE_DIR "/engine/classification/grass_model.yml";
};

void Photograph(const Arguments& arguments) {
  const Classifier classifier = Classifier::Parse(ReadTextFile(arguments.model));
  PoolOfRun pool;
  for (int i = 0; i < arguments.num_worlds; ++i) {
    const uint64_t seed = arguments.seed + static_cast<uint64_t>(i);
    pool.Add("seed " + std::to_string(seed), EvaluationPools().OfSeed(seed));
    PhotographWorld(seed, arguments.photographed, classifier);
  }
}

void WatchFolders(const Arguments& arguments) {
  std::vector<WatchRow> all;
  for (const std::string& folder : arguments.watched) {
    const auto rows = WatchPasses(folder, arguments.run);
    all.insert(all.end(), rows.begin(), rows.end());
  }
  std::cout << WatchReport(all);
}

void Fit(const Arguments& arguments) {
  std::vector<CueSample> all;
  for (const std::string& folder : arguments.watched) {
    const auto samples = SamplesOf(folder, arguments.run.watch);
    all.insert(all.end(), samples.begin(), samples.end());
  }
  std::cout << CueReport(all);
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

CLI::App* AddPhotograph(CLI::App& app, Arguments& arguments) {
  PhotographOptions& options = arguments.photographed;
  CLI::App* photograph = app.add_subcommand(
      "photograph", "flies over worlds, stores their sites, photographs later passes");
  photograph->add_option("--seed", arguments.seed, "of the first world");
  photograph->add_option("--worlds", arguments.num_worlds);
  photograph->add_option("--events", options.num_events, "passes with something new on the strip");
  photograph->add_option("--quiet", options.num_quiet, "passes with nothing new");
  photograph->add_option("--height", options.scenario.height_m, "of the stored pass, metres");
  photograph->add_option("--cell", options.scenario.cell_size_m, "of the world, metres");
  photograph->add_option("--texture", options.scenario.texture, "painted or recorded");
  photograph->add_option("--conditions", options.scenario.conditions, "plain or recorded");
  photograph->add_option("--noise", options.scenario.noise_scale, "multiplies errors of all poses");
  photograph->add_option("folder", options.folder, "for strips and passes")->required();
  return photograph;
}

int Main(int argc, char** argv) {
  Arguments arguments;
  WatchRunOptions& run = arguments.run;
  CLI::App app("Watches stored strips in later passes over seeded worlds");
  app.require_subcommand(1);
  CLI::App* photograph = AddPhotograph(app, arguments);
  CLI::App* watch = app.add_subcommand("watch", "watches the strips of photographed passes");
  watch->add_option("folders", arguments.watched, "of photograph")->required();
  watch->add_option("--log", run.log, "rows are added to this file, one for each photograph");
  watch->add_option("--pictures", run.pictures, "folder for pictures of misses and false alarms");
  CLI::App* fit = app.add_subcommand("fit", "weights of what tells things from other changes");
  fit->add_option("folders", arguments.watched, "of photograph")->required();
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
  if (*photograph) Photograph(arguments);
  if (*watch) WatchFolders(arguments);
  if (*fit) Fit(arguments);
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
