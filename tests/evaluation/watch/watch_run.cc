#include "tests/evaluation/watch/watch_run.h"

#include <algorithm>
#include <cstdio>
#include <map>

#include "tests/evaluation/engine_run.h"
#include "tests/evaluation/watch/comparison_picture.h"
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

PassPlan PlanOf(uint64_t seed, int pass, const WatchRunOptions& options) {
  PassPlan plan;
  plan.seed = MixSeed(seed, 9000 + static_cast<uint64_t>(pass));
  const auto choose = [&](uint64_t purpose, int count) {
    return static_cast<int>(MixSeed(plan.seed, purpose) % static_cast<uint64_t>(count));
  };
  // Kinds come in turns, all else by chance.
  plan.event = options.has_events ? static_cast<WatchEvent>(1 + pass % (kNumWatchEvents - 1))
                                  : WatchEvent::kNone;
  plan.change = static_cast<SceneChange>(options.has_events ? choose(1, kNumSceneChanges)
                                                            : pass % kNumSceneChanges);
  const int height = choose(2, static_cast<int>(options.height_ratios.size()));
  plan.height_m = options.scenario.height_m * options.height_ratios[static_cast<size_t>(height)];
  plan.tilt_deg = choose(3, kTiltPeriod) == 0 ? kTiltDeg : 0.0;
  plan.noise_scale = options.scenario.noise_scale;
  return plan;
}

std::vector<WatchRow> Watch(const std::string& name,
                            const StripPicture& strip,
                            const std::vector<PassPhoto>& photos,
                            const PassPlan& plan,
                            const WatchRunOptions& options) {
  std::vector<WatchRow> rows;
  StripWatch watch(options.watch);
  int num_pictures = 0;
  for (size_t i = 0; i < photos.size(); ++i) {
    const PassPhoto& photo = photos[i];
    const StripLook look = LookAtStrip(strip, photo.photo, options.watch);
    const StripWatch::Report report = watch.Add(look);
    WatchRow row{name,
                 NameOf(plan.event),
                 NameOf(plan.change),
                 plan.height_m,
                 plan.tilt_deg,
                 static_cast<int>(i),
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
    const bool is_missed = row.num_shown > 0 && row.num_found == 0;
    const bool is_false =
        row.num_things > 0 && row.num_shown == 0 && plan.event == WatchEvent::kNone;
    if (!options.pictures.empty() && (is_missed || is_false) && num_pictures++ < 2) {
      WriteComparison(strip,
                      photo.photo,
                      options.watch,
                      options.pictures + "/" + (is_missed ? "miss_" : "false_") + name + "_" +
                          row.event + "_" + row.change + "_" + std::to_string(i) + ".png");
    }
    rows.push_back(row);
  }
  return rows;
}

}  // namespace

std::vector<WatchRow> WatchWorld(uint64_t seed,
                                 const WatchRunOptions& options,
                                 const Classifier& classifier) {
  const Scenario scenario = MakeScenario(seed, options.scenario, [](double) {});
  const EngineRun run = RunEngine({scenario.rig, scenario.frames, scenario.aircraft},
                                  PipelineOptions(),
                                  classifier,
                                  [](double, const std::string&) { return true; });
  const Evaluation& evaluation = run.evaluation;
  const auto strips = StripsOf(evaluation, scenario, options.max_num_strips);
  std::vector<WatchRow> rows;
  if (strips.empty()) return rows;
  std::map<std::string, cv::Mat> images;
  for (const Frame& frame : scenario.frames) images[frame.id] = frame.image;
  const StoredGround stored(
      evaluation.map, evaluation.block, [&images](const std::string& id) { return images.at(id); });
  for (int pass = 0; pass < options.num_passes; ++pass) {
    const size_t which = static_cast<size_t>(pass) % strips.size();
    const PassPlan plan = PlanOf(seed, pass, options);
    const std::string name = std::to_string(seed) + "-" + std::to_string(pass);
    const StripPicture strip = stored.Around(strips[which], options.watch);
    const auto photos = FlySecondPass(scenario.world, scenario.rig.camera, strips[which], plan);
    const auto more = Watch(name, strip, photos, plan, options);
    rows.insert(rows.end(), more.begin(), more.end());
    if (!options.log.empty()) WriteRows(more, options.log);
  }
  return rows;
}

}  // namespace freelsd
