#include "tests/evaluation/campaign.h"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <limits>
#include <mutex>
#include <set>
#include <sstream>
#include <stdexcept>

#include <sys/resource.h>
#include <unistd.h>

#include "api/flight_parts.h"
#include "tests/evaluation/ablation/ablation.h"
#include "tests/evaluation/given/given_run.h"
#include "tests/evaluation/report.h"
#include "tests/evaluation/scores/blinded_counts.h"
#include "tests/evaluation/scores/blinding.h"
#include "tests/evaluation/stopwatch.h"
#include "tests/evaluation/truth_run.h"
#include "tests/evaluation/world_record.h"
#include "tests/synthetic/flight_files.h"

namespace freelsd {
namespace {

using Json = nlohmann::json;

// Of --blind: the run is scored as it is, and its map made wrong in each way besides.
constexpr const char* kEachBlinding = "each";

double PeakMib() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

// A bar on a terminal while one world is flown at a time, a line per world always.
class ProgressBar {
 public:
  ProgressBar(int num_worlds, int num_jobs)
      : num_worlds_(num_worlds), has_bar_(num_jobs == 1 && isatty(STDERR_FILENO) != 0) {}
  void Tell(int world, uint64_t seed, const std::string& stage, double done) const {
    if (!has_bar_) return;
    constexpr int kWidth = 30;
    const double all = (world + done) / num_worlds_;
    const int filled = static_cast<int>(kWidth * all);
    std::cerr << "\r[" << std::string(static_cast<size_t>(filled), '#')
              << std::string(static_cast<size_t>(kWidth - filled), '.') << "] world " << world + 1
              << " of " << num_worlds_ << ", seed " << seed << ", " << stage << " "
              << static_cast<int>(100.0 * done) << " %      " << std::flush;
  }
  void Line(const std::string& text) const {
    std::cerr << (has_bar_ ? "\r\033[K" : "") << text << std::endl;
  }

 private:
  int num_worlds_;
  bool has_bar_;
};

// Throws std::invalid_argument if the run mixes the pools, or if a seed is of neither.
Pool PoolOf(const CampaignOptions& options) {
  const Pools& pools = EvaluationPools();
  PoolOfRun run;
  for (const uint64_t seed : {options.seed, options.seed + options.num_worlds - 1}) {
    const std::optional<Pool> pool = pools.OfSeed(seed);
    if (!pool) {
      throw std::invalid_argument("seed " + std::to_string(seed) +
                                  " is of no pool: see tests/evaluation/pools.csv");
    }
    run.Add("seed " + std::to_string(seed), pool);
  }
  const std::string& ground = options.scenario.ground;
  run.Add("ground " + ground, pools.Of("ground", ground));
  for (const Pool pool : {Pool::kTuning, Pool::kReport}) {
    if (ground == NameOf(pool)) run.Add("ground " + ground, pool);
  }
  return *run.pool();
}

// What a report is about; reports of other settings cannot be continued.
Json SettingsOf(const CampaignOptions& options) {
  const ScenarioOptions& scenario = options.scenario;
  const Camera camera = PaperRig().camera;
  Json settings{
      {"world_size_m", scenario.world_size_m},
      {"cell_size_m", scenario.cell_size_m},
      {"height_m", scenario.height_m},
      {"leg_spacing_m", scenario.leg_spacing_m},
      {"noise_scale", scenario.noise_scale},
      {"damaged_ratio", scenario.damaged_ratio},
      {"aircraft", scenario.aircraft},
      {"image_size", std::to_string(camera.width_px) + "x" + std::to_string(camera.height_px)},
      {"threads", scenario.num_threads}};
  if (scenario.frame_spacing_m) {
    settings["frame_spacing_m"] = *scenario.frame_spacing_m;
    settings["num_frames"] = scenario.num_frames.value_or(NumFramesAt(*scenario.frame_spacing_m));
  } else {
    settings["frame_spacing_m"] = "mix";
    settings["num_frames"] = scenario.num_frames ? Json(*scenario.num_frames) : Json("by spacing");
  }
  if (!options.given.empty()) settings["given"] = options.given;
  if (options.is_heights_only) settings["heights_only"] = true;
  if (!scenario.takes_photographs) settings["on_truth"] = true;
  if (!options.blind.empty()) settings["blind"] = options.blind;
  if (!options.ablations.empty()) settings["ablations"] = options.ablations;
  if (scenario.gives_wires) settings["gives_wires"] = true;
  if (!options.engine_options.empty()) settings["options"] = options.engine_options;
  settings["pool"] = NameOf(PoolOf(options));
  if (!scenario.ground.empty()) settings["ground"] = scenario.ground;
  if (scenario.texture != "painted") settings["texture"] = scenario.texture;
  if (scenario.conditions != "plain") settings["conditions"] = scenario.conditions;
  return settings;
}

PipelineOptions OptionsFor(const CampaignOptions& campaign, const Aircraft& aircraft) {
  PipelineOptions options = ParseOptions(campaign.engine_options, "");
  options.regions.min_area_m2 = aircraft.min_area_m2;
  options.adjustment.num_threads = campaign.scenario.num_threads;
  return options;
}

// As a client would give them: the poles' places, the height above ground.
std::vector<HardObstacle> WiresOf(const World& world) {
  constexpr double kPositionSdM = 2.0;
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  std::vector<HardObstacle> wires;
  for (const PowerLine& line : world.power_lines) {
    wires.push_back(
        {"wire-" + std::to_string(wires.size() + 1),
         HardObstacle::Shape::kLine,
         {{line.start.x(), line.start.y(), kUnknown}, {line.end.x(), line.end.y(), kUnknown}},
         line.height_m,
         kPositionSdM});
  }
  return wires;
}

struct TrueWorld {
  uint64_t seed = 0;
  const Scenario& scenario;
  const TruthMap& truth;
  // Empty if nothing is planned.
  const Fields& fields;
};

EngineRun RunOf(const CampaignOptions& campaign,
                const GroundModel& ground_model,
                const TrueWorld& world,
                const Progress& progress) {
  const Scenario& scenario = world.scenario;
  const PipelineOptions options = OptionsFor(campaign, scenario.aircraft);
  // It is judged with the aircraft as it is.
  const Aircraft aircraft =
      options.preset == Preset::kPaper ? PaperAircraft(scenario.aircraft) : scenario.aircraft;
  const GivenTruth given{Given::Of(campaign.given), scenario, world.truth};
  return RunEngine(
      {scenario.rig,
       scenario.frames,
       aircraft,
       campaign.scenario.gives_wires ? WiresOf(scenario.world) : std::vector<HardObstacle>(),
       campaign.is_heights_only,
       campaign.given.empty() ? EvaluateFlight() : EvaluateGiven(given, aircraft)},
      options,
      ground_model,
      progress);
}

EngineRun PlannedRun(const CampaignOptions& campaign,
                     const GroundModel& ground_model,
                     const TrueWorld& world,
                     const Progress& progress) {
  const auto& [seed, scenario, truth, fields] = world;
  const ApproachOptions options = OptionsFor(campaign, scenario.aircraft).approach;
  EngineRun run = campaign.scenario.takes_photographs
                      ? RunOf(campaign, ground_model, world, progress)
                      : RunOnTruth(scenario, truth, fields, options);
  if (const auto blinding = BlindingNamed(campaign.blind)) {
    run = RunBlinded(scenario, truth, fields, run, *blinding, options);
  }
  progress(1.0, "approach");
  return run;
}

Json PlannedRecord(const CampaignOptions& campaign,
                   const GroundModel& ground_model,
                   const TrueWorld& world,
                   const Progress& progress) {
  const auto& [seed, scenario, truth, fields] = world;
  const EngineRun run = PlannedRun(campaign, ground_model, world, progress);
  const PipelineOptions options = OptionsFor(campaign, scenario.aircraft);
  Json record = WorldRecord(seed, scenario, run, truth, fields, options);
  if (campaign.blind == kEachBlinding) {
    record["blinded"] = CountBlinded(scenario, truth, fields, run, options.approach, seed);
  }
  if (!campaign.ablations.empty()) {
    record["ablations"] = CountAblations(
        scenario, truth, fields, run, {campaign.ablations, campaign.engine_options}, seed);
  }
  return record;
}

Json RecordOf(const CampaignOptions& campaign,
              const GroundModel& ground_model,
              const TrueWorld& world,
              const Progress& progress) {
  if (!campaign.is_heights_only) return PlannedRecord(campaign, ground_model, world, progress);
  const EngineRun run = RunOf(campaign, ground_model, world, progress);
  progress(1.0, "hazards");
  return HeightsRecord(world.seed, world.scenario, run, world.truth);
}

Json EvaluateWorld(const CampaignOptions& campaign,
                   const GroundModel& ground_model,
                   uint64_t seed,
                   const Progress& progress) {
  const int num_threads = campaign.scenario.num_threads;
  Stopwatch stopwatch(num_threads > 1);
  const Scenario scenario = MakeScenario(seed, campaign.scenario, [&](double done) {
    stopwatch.Lap(done == 0.0 ? "world" : "photographs");
    progress(0.5 * done, "rendering");
  });
  const TruthMap truth = MakeTruthMap(scenario.world, scenario.aircraft);
  const Fields fields = campaign.is_heights_only
                            ? Fields()
                            : FindFields(scenario.world, truth, scenario.aircraft, scenario.seen);
  stopwatch.Lap("truth");
  Json record = RecordOf(campaign,
                         ground_model,
                         {seed, scenario, truth, fields},
                         [&](double done, const std::string& stage) {
                           stopwatch.Lap(stage == "frontend" ? stage : "backend");
                           return progress(0.5 + 0.5 * done, stage);
                         });
  stopwatch.Lap("scores");
  if (!scenario.ground.empty()) record["ground"] = scenario.ground;
  record["cpu_s"] = stopwatch.seconds();
  record["peak_mib"] = std::round(PeakMib());
  return record;
}

// Of one world.
std::string HeightsLine(const Json& record) {
  const Json& figures = record.at("heights").at("figures");
  std::ostringstream line;
  line << "heights " << figures.at("median_m") << " m median, " << figures.at("p95_m")
       << " m 95 %, beyond 3 sd " << figures.at("beyond_3_sd_ratio") << ", unknown "
       << figures.at("unknown_ratio");
  return line.str();
}

std::string SafetyLine(const Json& record) {
  const Json report = MakeReport(Json::object(), Json::array({record}));
  const Json& safety = report.at("safety");
  std::ostringstream line;
  line << safety.at("num_landable_sites") << " landable, " << safety.at("num_unverified_sites")
       << " unverified, " << safety.at("num_rejected_sites") << " rejected, "
       << safety.at("num_false_safe") << " false safe; " << safety.at("num_fields_found") << " of "
       << safety.at("num_fields") << " fields found";
  return line.str();
}

std::string LineOf(const Json& record) {
  std::ostringstream line;
  line << "seed " << record.at("seed") << ", " << record.at("aircraft").get<std::string>() << ", "
       << record.at("spacing_m")
       << " m apart: " << (record.contains("sites") ? SafetyLine(record) : HeightsLine(record))
       << "; engine " << std::lround(record.at("total_s").get<double>()) << " s";
  return line.str();
}

void Sort(Json& records) {
  std::sort(records.begin(), records.end(), [](const Json& a, const Json& b) {
    return a.at("seed").get<uint64_t>() < b.at("seed").get<uint64_t>();
  });
}

// The records of an earlier run with the same settings, of the seeds that are asked for.
Json ReadRecords(const CampaignOptions& options) {
  if (!options.resumes) return Json::array();
  const Json report = ReadReportToContinue(options.json, SettingsOf(options));
  Json records = Json::array();
  for (const Json& record : report.value("worlds", Json::array())) {
    const auto seed = record.at("seed").get<uint64_t>();
    if (seed >= options.seed && seed - options.seed < static_cast<uint64_t>(options.num_worlds)) {
      records.push_back(record);
    }
  }
  return records;
}

// Flies the worlds that are not in the report yet, several at once, and takes their records.
class Campaign {
 public:
  Campaign(const CampaignOptions& options, const GroundModel& ground_model)
      : options_(options),
        ground_model_(ground_model),
        records_(ReadRecords(options)),
        bar_(options.num_worlds, options.num_jobs) {}

  Json Run() {
    const std::vector<int> worlds = WorldsToFly();
    DoAll(worlds.size(), options_.num_jobs, [&](size_t i) { Fly(worlds[i]); });
    return Report();
  }

 private:
  uint64_t SeedOf(int world) const { return options_.seed + static_cast<uint64_t>(world); }

  std::vector<int> WorldsToFly() const {
    std::set<uint64_t> done;
    for (const Json& record : records_) done.insert(record.at("seed").get<uint64_t>());
    std::vector<int> worlds;
    for (int world = 0; world < options_.num_worlds; ++world) {
      if (!done.contains(SeedOf(world))) worlds.push_back(world);
    }
    return worlds;
  }

  void Fly(int world) {
    const uint64_t seed = SeedOf(world);
    Keep(EvaluateWorld(options_, ground_model_, seed, [&](double share, const std::string& stage) {
      bar_.Tell(world, seed, stage, share);
      return true;
    }));
  }

  void Keep(Json record) {
    const std::lock_guard<std::mutex> lock(mutex_);
    bar_.Line(LineOf(record));
    records_.push_back(std::move(record));
    Sort(records_);
    if (!options_.json.empty()) WriteTextFile(options_.json, Report().dump(1) + "\n");
  }

  Json Report() const { return MakeReport(SettingsOf(options_), records_); }

  const CampaignOptions& options_;
  const GroundModel& ground_model_;
  // Guards records_, which the jobs share, and the file of the records.
  std::mutex mutex_;
  Json records_;
  ProgressBar bar_;
};

}  // namespace

std::string CampaignOptions::ModelFile() const {
  return ModelFileFor(ParseOptions(engine_options, ""));
}

void CampaignOptions::Check() const {
  scenario.Check();
  PoolOf(*this);
  if (!blind.empty() && blind != kEachBlinding && !BlindingNamed(blind)) {
    throw std::invalid_argument("--blind " + blind + ": no such blinding");
  }
  Given::Of(given);
  if (!given.empty() && !scenario.takes_photographs) {
    throw std::invalid_argument("--on-truth is given everything: not with --given");
  }
  const bool is_plain = scenario.takes_photographs && blind.empty() && ablations.empty();
  if (is_heights_only && !is_plain) {
    throw std::invalid_argument(
        "--heights-only plans nothing: not with --on-truth, --blind or --ablate");
  }
  if (resumes && json.empty()) throw std::invalid_argument("--resume needs --json");
  if (num_jobs > 1 && scenario.num_threads > 1) {
    throw std::invalid_argument("--jobs and --threads: only one of them can be more than 1");
  }
}

Json RunCampaign(const CampaignOptions& options, const GroundModel& ground_model) {
  options.Check();
  cv::setNumThreads(options.scenario.num_threads);
  return Campaign(options, ground_model).Run();
}

}  // namespace freelsd
