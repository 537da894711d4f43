// freelsd-look: over worlds with a half-finished survey, flies the legs that the engine suggests
// next, and random ones; tells which gained more.
#include <algorithm>
#include <exception>
#include <iostream>
#include <mutex>
#include <set>

#include <CLI/CLI.hpp>

#include "tests/evaluation/engine_run.h"
#include "tests/evaluation/look/look_report.h"
#include "tests/evaluation/look/look_run.h"
#include "tests/evaluation/runs/runs.h"

namespace freelsd {
namespace {

using Json = nlohmann::json;

struct Arguments {
  LookRunOptions run;
  uint64_t seed = 1000;
  int num_worlds = 6;
  int num_jobs = 1;
  std::string json;
  bool resumes = false;
};

// Throws std::invalid_argument if the seeds are of no pool, or of both.
Json SettingsFor(const Arguments& arguments) {
  PoolOfRun pool;
  for (const uint64_t seed : {arguments.seed, arguments.seed + arguments.num_worlds - 1}) {
    const auto of_seed = EvaluationPools().OfSeed(seed);
    if (!of_seed) throw std::invalid_argument("seed " + std::to_string(seed) + " is of no pool");
    pool.Add("seed " + std::to_string(seed), of_seed);
  }
  const LookWorldOptions& world = arguments.run.world;
  return {{"pool", NameOf(*pool.pool())},
          {"aircraft", world.aircraft},
          {"num_survey_legs", world.num_survey_legs},
          {"survey_leg_m", world.survey_leg_m},
          {"look_leg_m", world.look_leg_m},
          {"num_legs", arguments.run.look.num_legs},
          {"num_random_pairs", arguments.run.num_random_pairs}};
}

Json RecordsSoFar(const Arguments& arguments, const Json& settings) {
  if (!arguments.resumes || arguments.json.empty()) return Json::array();
  return ReadReportToContinue(arguments.json, settings).value("worlds", Json::array());
}

Json RunWorlds(const Arguments& arguments) {
  const Json settings = SettingsFor(arguments);
  Json records = RecordsSoFar(arguments, settings);
  std::set<uint64_t> done;
  for (const Json& record : records) done.insert(record.at("seed").get<uint64_t>());
  const Classifier classifier = Classifier::Parse(ReadTextFile(ModelFileFor({})));
  // Guards records and the file of the report.
  std::mutex mutex;
  DoAll(static_cast<size_t>(arguments.num_worlds), arguments.num_jobs, [&](size_t i) {
    const uint64_t seed = arguments.seed + i;
    if (done.contains(seed)) return;
    Json record = RunLook(seed, arguments.run, classifier);
    const std::lock_guard lock(mutex);
    std::cerr << LookGains(record).dump() << "\n";
    records.push_back(std::move(record));
    std::sort(records.begin(), records.end(), [](const Json& a, const Json& b) {
      return a.at("seed").get<uint64_t>() < b.at("seed").get<uint64_t>();
    });
    if (!arguments.json.empty()) {
      WriteTextFile(arguments.json, LookReport(settings, records).dump(1) + "\n");
    }
  });
  return LookReport(settings, records);
}

}  // namespace
}  // namespace freelsd

int main(int argc, char** argv) {
  try {
    freelsd::Arguments arguments;
    // The legs are short, so that they end within the world.
    arguments.run.look.leg_length_m = arguments.run.world.look_leg_m;
    CLI::App app(
        "Compares the legs that the engine suggests with random ones, over seeded worlds.");
    app.add_option("--worlds", arguments.num_worlds, "number of worlds")
        ->check(CLI::Range(1, 10000));
    app.add_option("--seed", arguments.seed, "seed of the first world; the others follow");
    app.add_option("--jobs", arguments.num_jobs, "worlds at once")->check(CLI::Range(1, 64));
    app.add_option("--pairs", arguments.run.num_random_pairs, "random pairs of legs per world")
        ->check(CLI::Range(1, 28));
    app.add_option("--aircraft", arguments.run.world.aircraft, "both takes turns")
        ->check(CLI::IsMember({"both", "techpod", "small", "atlantiksolar"}));
    app.add_option("--json", arguments.json, "report to write, after every world");
    app.add_flag("--resume", arguments.resumes, "go on from the report");
    app.add_option("--pictures", arguments.run.pictures, "folder for pictures of maps and legs");
    CLI11_PARSE(app, argc, argv);
    cv::setNumThreads(1);
    std::cout << freelsd::LookTable(freelsd::RunWorlds(arguments));
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "freelsd-look: " << error.what() << "\n";
    return 1;
  }
}
