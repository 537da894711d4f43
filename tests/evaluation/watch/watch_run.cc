#include "tests/evaluation/watch/watch_run.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>

#include "tests/evaluation/engine_run.h"
#include "tests/evaluation/watch/comparison_picture.h"
#include "tests/evaluation/watch/pass_file.h"
#include "tests/evaluation/watch/second_pass.h"
#include "tests/evaluation/watch/stored_ground.h"
#include "tests/synthetic/noise.h"
#include "tests/synthetic/truth.h"

namespace freelsd {
namespace {

// A thing is found if the engine's place is as near as this: the map may lie beside the world.
constexpr double kMaxPlaceErrorM = 4.0;
// A third of the passes looks ahead.
constexpr double kTiltDeg = 35.0;
constexpr int kTiltPeriod = 3;

using Strip = std::vector<Polygon>;

// Ground roll from a touchdown, as the planner has it.
std::vector<Eigen::Vector3d> GroundRollFrom(const Eigen::Vector2d& touchdown,
                                            double heading,
                                            const Aircraft& aircraft) {
  const Eigen::Vector2d forward = DirectionOf(heading);
  const Eigen::Vector2d along = aircraft.ground_roll_m * forward;
  const Eigen::Vector2d right =
      aircraft.path_half_width_m * Eigen::Vector2d(forward.y(), -forward.x());
  std::vector<Eigen::Vector3d> corners;
  for (const Eigen::Vector2d& offset : {right,
                                        Eigen::Vector2d(right + along),
                                        Eigen::Vector2d(along - right),
                                        Eigen::Vector2d(-right)}) {
    corners.emplace_back(touchdown.x() + offset.x(), touchdown.y() + offset.y(), 0.0);
  }
  return corners;
}

// The engine's sites; where it accepts none, the touchdowns of the true fields that were seen.
std::vector<Strip> StripsOf(const Evaluation& evaluation,
                            const Scenario& scenario,
                            int max_num_strips) {
  const Aircraft& aircraft = scenario.aircraft;
  std::vector<Strip> strips;
  const auto is_full = [&] { return static_cast<int>(strips.size()) >= max_num_strips; };
  for (const Site& site : evaluation.sites) {
    if (site.plan.verdict == Verdict::kRejected || !site.plan.approach || is_full()) continue;
    strips.push_back(OutlinesOf(site.plan.touchdown_in_world.head<2>(),
                                aircraft.touchdown_uncertainty_m,
                                site.plan.approach->ground_roll_in_world));
  }
  if (!strips.empty()) return strips;
  const double into_wind = HeadingOf(-scenario.world.wind_in_world);
  for (const TrueField& field : JudgeFields(scenario.world, aircraft)) {
    if (!field.touchdown || field.free_radius < aircraft.touchdown_uncertainty_m || is_full()) {
      continue;
    }
    const auto cell = evaluation.map.grid.CellAt(*field.touchdown);
    if (!cell || !evaluation.map.IsSeen(cell->y, cell->x)) continue;
    strips.push_back(OutlinesOf(*field.touchdown,
                                aircraft.touchdown_uncertainty_m,
                                GroundRollFrom(*field.touchdown, into_wind, aircraft)));
  }
  return strips;
}

int NumFound(const std::vector<NewThing>& things, const std::vector<Eigen::Vector2d>& truth) {
  return static_cast<int>(std::count_if(truth.begin(), truth.end(), [&](const auto& place) {
    return std::any_of(things.begin(), things.end(), [&](const NewThing& thing) {
      return (thing.place_in_world.head<2>() - place).norm() <=
             kMaxPlaceErrorM + 0.5 * thing.length_m;
    });
  }));
}

PassPlan PlanOf(uint64_t seed, int pass, const PhotographOptions& options) {
  const bool is_quiet = pass >= options.num_events;
  const int number = is_quiet ? pass - options.num_events : pass;
  PassPlan plan;
  plan.seed = MixSeed(MixSeed(seed, is_quiet ? 9500 : 9000), static_cast<uint64_t>(number));
  const auto choose = [&](uint64_t purpose, int count) {
    return static_cast<int>(MixSeed(plan.seed, purpose) % static_cast<uint64_t>(count));
  };
  // Events, and the light of quiet passes, come in turns, all else by chance.
  plan.event =
      is_quiet ? WatchEvent::kNone : static_cast<WatchEvent>(1 + number % (kNumWatchEvents - 1));
  plan.change =
      static_cast<SceneChange>(is_quiet ? number % kNumSceneChanges : choose(1, kNumSceneChanges));
  const int height = choose(2, static_cast<int>(options.height_ratios.size()));
  plan.height_m = options.scenario.height_m * options.height_ratios[static_cast<size_t>(height)];
  plan.tilt_deg = choose(3, kTiltPeriod) == 0 ? kTiltDeg : 0.0;
  plan.noise_scale = options.scenario.noise_scale;
  return plan;
}

// Some field of the world could hold a strip: tells before anything is photographed.
bool MayHaveStrip(uint64_t seed, ScenarioOptions options) {
  options.takes_photographs = false;
  const Scenario scenario = MakeScenario(seed, options, [](double) {});
  const auto fields = JudgeFields(scenario.world, scenario.aircraft);
  return std::any_of(fields.begin(), fields.end(), [&](const TrueField& field) {
    return field.touchdown && field.free_radius >= scenario.aircraft.touchdown_uncertainty_m;
  });
}

// Stored strips of a world.
struct StoredWorld {
  Scenario scenario;
  std::vector<StripPicture> strips;
};

std::optional<StoredWorld> StoreWorld(uint64_t seed,
                                      const PhotographOptions& options,
                                      const Classifier& classifier) {
  if (!MayHaveStrip(seed, options.scenario)) return std::nullopt;
  StoredWorld world{MakeScenario(seed, options.scenario, [](double) {}), {}};
  const Scenario& scenario = world.scenario;
  const EngineRun run = RunEngine({scenario.rig, scenario.frames, scenario.aircraft},
                                  PipelineOptions(),
                                  classifier,
                                  [](double, const std::string&) { return true; });
  const auto strips = StripsOf(run.evaluation, scenario, options.max_num_strips);
  if (strips.empty()) return std::nullopt;
  std::map<std::string, cv::Mat> images;
  for (const Frame& frame : scenario.frames) images[frame.id] = frame.image;
  const StoredGround stored(run.evaluation.map,
                            run.evaluation.block,
                            [&images](const std::string& id) { return images.at(id); });
  for (const Strip& strip : strips) world.strips.push_back(stored.Around(strip, WatchOptions()));
  return world;
}

bool IsMissed(const WatchRow& row) { return row.num_shown > 0 && row.num_found == 0; }

bool IsFalseAlarm(const WatchRow& row) {
  return row.num_things > 0 && row.event == NameOf(WatchEvent::kNone);
}

std::vector<WatchRow> Watch(const StripPicture& strip,
                            const RecordedPass& pass,
                            const WatchRunOptions& options) {
  std::vector<WatchRow> rows;
  StripWatch watch(options.watch);
  for (const PassPhoto& photo : pass.photos) {
    const WatchedPhoto watched = photo.Read();
    const StripLook look = LookAtStrip(strip, watched, options.watch);
    const StripWatch::Report report = watch.Add(look);
    WatchRow row{pass.name,
                 NameOf(pass.plan.event),
                 NameOf(pass.plan.change),
                 pass.plan.height_m,
                 pass.plan.tilt_deg,
                 static_cast<int>(rows.size()),
                 look.result,
                 report.status,
                 look.compared_ratio,
                 look.correlation,
                 static_cast<int>(look.things.size()),
                 look.things.empty() ? 0.0 : look.things.front().deviations,
                 static_cast<int>(photo.shown_things.size()),
                 NumFound(look.things, photo.shown_things),
                 false};
    row.is_told =
        report.status == StripStatus::kOccupied && NumFound(report.things, photo.shown_things) > 0;
    if (!options.pictures.empty() && (IsMissed(row) || IsFalseAlarm(row))) {
      WriteComparison(strip,
                      watched,
                      options.watch,
                      options.pictures + "/" + (IsMissed(row) ? "miss_" : "false_") + pass.name +
                          "_" + row.event + "_" + row.change + "_" + std::to_string(row.number) +
                          ".png");
    }
    rows.push_back(row);
  }
  return rows;
}

}  // namespace

void PhotographWorld(uint64_t seed,
                     const PhotographOptions& options,
                     const Classifier& classifier) {
  const std::string prefix = options.folder + "/" + std::to_string(seed);
  if (std::filesystem::exists(prefix + ".done")) return;
  std::filesystem::create_directories(options.folder);
  const auto world = StoreWorld(seed, options, classifier);
  const auto strip_file = [&](size_t which) {
    return std::to_string(seed) + "-" + std::to_string(which) + ".strip";
  };
  const size_t num_strips = world ? world->strips.size() : 0;
  for (size_t i = 0; i < num_strips; ++i) {
    WriteStrip(world->strips[i], options.folder + "/" + strip_file(i));
  }
  const int num_passes = num_strips == 0 ? 0 : options.num_events + options.num_quiet;
  for (int i = 0; i < num_passes; ++i) {
    const std::string name = std::to_string(seed) + "-" + std::to_string(i);
    const std::string file = options.folder + "/" + name + ".pass";
    if (std::filesystem::exists(file)) continue;
    const size_t which = static_cast<size_t>(i) % num_strips;
    const PassPlan plan = PlanOf(seed, i, options);
    const auto photos = FlySecondPass(
        world->scenario.world, world->scenario.rig.camera, world->strips[which].outlines, plan);
    WritePass({name, strip_file(which), plan, photos}, file + ".part");
    std::filesystem::rename(file + ".part", file);
  }
  std::ofstream(prefix + ".done") << num_passes << '\n';
}

std::vector<WatchRow> WatchPasses(const std::string& folder, const WatchRunOptions& options) {
  std::vector<WatchRow> rows;
  for (const std::string& file : PassFilesIn(folder)) {
    const RecordedPass pass = ReadPass(file);
    const auto more = Watch(ReadStrip(folder + "/" + pass.strip_file), pass, options);
    rows.insert(rows.end(), more.begin(), more.end());
    if (!options.log.empty()) WriteRows(more, options.log);
  }
  return rows;
}

}  // namespace freelsd
