// freelsd-eval: the whole engine over seeded worlds whose truth is known; one table, and JSON.
#include <cmath>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <sys/resource.h>
#include <unistd.h>

#include "tests/evaluation/curves.h"
#include "tests/evaluation/pictures.h"
#include "tests/evaluation/report.h"
#include "tests/evaluation/world_record.h"

namespace freelsd {
namespace {

using Json = nlohmann::json;

struct Arguments {
  int num_worlds = 6;
  uint64_t seed = 1000;
  ScenarioOptions scenario;
  std::string json;
  std::string compare;
  std::string pictures;
  std::string model = FREELSD_SOURCE_DIR "/engine/classification/grass_model.yml";
  bool resume = false;
  // Limits of the exit status; negative: none.
  int max_false_safe = -1;
  double min_found_ratio = -1.0;
};

std::string ReadFile(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error("cannot read " + path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

// Whole or not at all: a run that is interrupted must not spoil what it would go on from.
void WriteFile(const std::string& path, const std::string& text) {
  const std::string part = path + ".part";
  {
    std::ofstream file(part, std::ios::binary);
    file << text;
    file.flush();
    if (!file) throw std::runtime_error("cannot write " + part);
  }
  std::filesystem::rename(part, path);
}

// A bar on a terminal, a line per world otherwise.
class ProgressBar {
 public:
  explicit ProgressBar(int num_worlds) : num_worlds_(num_worlds) {}
  void Tell(int world, uint64_t seed, const std::string& stage, double done) const {
    if (!is_terminal_) return;
    constexpr int kWidth = 30;
    const double all = (world + done) / num_worlds_;
    const int filled = static_cast<int>(kWidth * all);
    std::cerr << "\r[" << std::string(static_cast<size_t>(filled), '#')
              << std::string(static_cast<size_t>(kWidth - filled), '.') << "] world " << world + 1
              << " of " << num_worlds_ << ", seed " << seed << ", " << stage << " "
              << static_cast<int>(100.0 * done) << " %      " << std::flush;
  }
  void Line(const std::string& text) const {
    std::cerr << (is_terminal_ ? "\r\033[K" : "") << text << std::endl;
  }

 private:
  int num_worlds_;
  bool is_terminal_ = isatty(STDERR_FILENO) != 0;
};

double PeakMib() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

// What a report is about; reports of other settings cannot be continued.
Json SettingsOf(const Arguments& arguments) {
  const ScenarioOptions& scenario = arguments.scenario;
  return {{"world_size_m", scenario.world_size_m},
          {"cell_size_m", scenario.cell_size_m},
          {"num_frames", scenario.num_frames},
          {"height_m", scenario.height_m},
          {"frame_spacing_m", scenario.frame_spacing_m},
          {"leg_spacing_m", scenario.leg_spacing_m},
          {"noise_scale", scenario.noise_scale},
          {"damaged_ratio", scenario.damaged_ratio},
          {"aircraft", scenario.aircraft},
          {"image_size", "752x480"},
          {"threads", scenario.num_threads}};
}

PipelineOptions OptionsFor(const Aircraft& aircraft, int num_threads) {
  PipelineOptions options;
  options.regions.min_area_m2 = aircraft.min_area_m2;
  options.adjustment.num_threads = num_threads;
  return options;
}

Json EvaluateWorld(const Arguments& arguments,
                   const Classifier& classifier,
                   uint64_t seed,
                   const Progress& progress) {
  const Scenario scenario = MakeScenario(
      seed, arguments.scenario, [&](double done) { progress(0.5 * done, "rendering"); });
  const EngineRun run = RunEngine(
      scenario.rig,
      scenario.frames,
      scenario.aircraft,
      OptionsFor(scenario.aircraft, arguments.scenario.num_threads),
      classifier,
      [&](double done, const std::string& stage) { return progress(0.5 + 0.5 * done, stage); });
  const TruthMap truth = MakeTruthMap(scenario.world, scenario.aircraft);
  const Fields fields = FindFields(scenario.world, truth, scenario.aircraft, scenario.seen);
  if (!arguments.pictures.empty()) {
    DrawWorld(arguments.pictures, std::to_string(seed), scenario, run, truth, fields);
    DrawCurves(arguments.pictures, std::to_string(seed), run);
  }
  Json record = WorldRecord(seed, scenario, run, truth, fields);
  record["peak_mib"] = std::round(PeakMib());
  return record;
}

std::string LineOf(const Json& record) {
  const Json report = MakeReport(Json::object(), Json::array({record}));
  const Json& safety = report.at("safety");
  std::ostringstream line;
  line << "seed " << record.at("seed") << ", " << record.at("aircraft").get<std::string>() << ": "
       << safety.at("num_landable_sites") << " landable, " << safety.at("num_unverified_sites")
       << " unverified, " << safety.at("num_rejected_sites") << " rejected, "
       << safety.at("num_false_safe") << " false safe; " << safety.at("num_fields_found") << " of "
       << safety.at("num_fields") << " fields found; engine "
       << std::lround(record.at("total_s").get<double>()) << " s";
  return line.str();
}

// The records of an earlier run with the same settings.
Json ReadRecords(const Arguments& arguments) {
  if (!arguments.resume || !std::filesystem::exists(arguments.json)) return Json::array();
  const Json report = Json::parse(ReadFile(arguments.json));
  if (report.at("settings") != SettingsOf(arguments)) {
    throw std::runtime_error(arguments.json +
                             " was made with other settings: " + report.at("settings").dump());
  }
  return report.at("worlds");
}

Json EvaluateAll(const Arguments& arguments) {
  const Classifier classifier = Classifier::Parse(ReadFile(arguments.model));
  Json records = ReadRecords(arguments);
  std::set<uint64_t> done;
  for (const Json& record : records) done.insert(record.at("seed").get<uint64_t>());
  const ProgressBar bar(arguments.num_worlds);
  for (int i = 0; i < arguments.num_worlds; ++i) {
    const uint64_t seed = arguments.seed + static_cast<uint64_t>(i);
    if (done.contains(seed)) continue;
    records.push_back(
        EvaluateWorld(arguments, classifier, seed, [&](double share, const std::string& stage) {
          bar.Tell(i, seed, stage, share);
          return true;
        }));
    bar.Line(LineOf(records.back()));
    if (!arguments.json.empty()) {
      WriteFile(arguments.json, MakeReport(SettingsOf(arguments), records).dump(1) + "\n");
    }
  }
  return MakeReport(SettingsOf(arguments), records);
}

// Status 3 where a limit is passed: the run itself went well.
int StatusOf(const Arguments& arguments, const Json& safety) {
  int status = 0;
  const int64_t num_false_safe = safety.at("num_false_safe").get<int64_t>();
  if (arguments.max_false_safe >= 0 && num_false_safe > arguments.max_false_safe) {
    std::cerr << "freelsd-eval: " << num_false_safe << " sites are false safe, at most "
              << arguments.max_false_safe << " may be\n";
    status = 3;
  }
  const Json& found = safety.at("fields_found_ratio");
  if (arguments.min_found_ratio >= 0.0 && found.is_number() &&
      found.get<double>() < arguments.min_found_ratio) {
    std::cerr << "freelsd-eval: " << found << " of the fields were found, at least "
              << arguments.min_found_ratio << " must be\n";
    status = 3;
  }
  return status;
}

// Of the classifier, over the regions of all worlds.
RocCounts RegionRoc(const Json& report) {
  RocCounts counts;
  for (const Json& record : report.at("worlds")) {
    counts.Add(RocFromJson(record.at("frontend").at("regions")));
  }
  return counts;
}

int Run(const Arguments& arguments) {
  arguments.scenario.Check();
  if (arguments.resume && arguments.json.empty()) {
    throw std::invalid_argument("--resume needs --json");
  }
  cv::setNumThreads(arguments.scenario.num_threads);
  const Json report = EvaluateAll(arguments);
  std::cout << TableOf(report);
  if (!arguments.pictures.empty()) DrawRoc(arguments.pictures, "all", RegionRoc(report));
  if (!arguments.compare.empty()) {
    std::cout << Comparison(Json::parse(ReadFile(arguments.compare)), report);
  }
  return StatusOf(arguments, report.at("safety"));
}

}  // namespace
}  // namespace freelsd

int main(int argc, char** argv) {
  freelsd::Arguments arguments;
  CLI::App app(
      "Scores the engine over seeded worlds whose truth is known. Status 3: a limit was passed.");
  app.add_option("--worlds", arguments.num_worlds, "number of worlds")
      ->check(CLI::Range(1, 100000));
  app.add_option("--seed", arguments.seed, "seed of the first world; the others follow");
  app.add_option("--json", arguments.json, "report to write, after every world");
  app.add_flag("--resume", arguments.resume, "go on from the report: its seeds are not run again");
  app.add_option("--compare", arguments.compare, "older report: says what got better and worse");
  app.add_option(
      "--plots,--pictures", arguments.pictures, "folder for pictures of worlds and maps");
  app.add_option("--model", arguments.model, "grass classifier");
  app.add_option("--noise", arguments.scenario.noise_scale, "scale of the autopilot's errors")
      ->check(CLI::Range(0.0, 10.0));
  app.add_option("--damage", arguments.scenario.damaged_ratio, "share of photographs damaged")
      ->check(CLI::Range(0.0, 1.0));
  app.add_option("--frames", arguments.scenario.num_frames, "photographs per world")
      ->check(CLI::Range(3, 300));
  app.add_option("--size", arguments.scenario.world_size_m, "side of a world in metres")
      ->check(CLI::Range(100.0, 1000.0));
  app.add_option("--cell", arguments.scenario.cell_size_m, "texture of a world in metres")
      ->check(CLI::Range(0.1, 1.0));
  app.add_option("--height", arguments.scenario.height_m, "height of flight in metres")
      ->check(CLI::Range(30.0, 400.0));
  app.add_option("--aircraft", arguments.scenario.aircraft, "both takes turns")
      ->check(CLI::IsMember({"both", "techpod", "small", "atlantiksolar"}));
  app.add_option("--threads", arguments.scenario.num_threads, "threads; no result depends on them")
      ->check(CLI::Range(1, 64));
  app.add_option("--max-false-safe", arguments.max_false_safe, "limit of the exit status");
  app.add_option("--min-found-ratio", arguments.min_found_ratio, "limit of the exit status");
  CLI11_PARSE(app, argc, argv);
  try {
    return freelsd::Run(arguments);
  } catch (const std::exception& error) {
    std::cerr << "freelsd-eval: " << error.what() << "\n";
    return 1;
  }
}
