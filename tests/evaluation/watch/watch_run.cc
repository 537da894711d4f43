#include "tests/evaluation/watch/watch_run.h"

#include <algorithm>
#include <cstdio>
#include <map>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "engine/watch/change.h"
#include "engine/watch/registration.h"
#include "engine/watch/strip_canvas.h"
#include "tests/evaluation/engine_run.h"
#include "tests/evaluation/watch/later_world.h"
#include "tests/evaluation/watch/stored_ground.h"
#include "tests/synthetic/noise.h"

namespace freelsd {
namespace {

// A thing is found if the engine's place is as near as this: the map may lie beside the world.
constexpr double kMaxPlaceErrorM = 4.0;
// A third of the passes looks ahead.
constexpr double kTiltDeg = 35.0;
constexpr int kTiltPeriod = 3;

std::vector<std::vector<Polygon>> StripsOf(const Evaluation& evaluation,
                                           const Aircraft& aircraft,
                                           int max_num_strips) {
  std::vector<std::vector<Polygon>> strips;
  for (const Site& site : evaluation.sites) {
    if (site.plan.verdict == Verdict::kRejected || !site.plan.approach) continue;
    if (static_cast<int>(strips.size()) == max_num_strips) break;
    strips.push_back(OutlinesOf(site.plan.touchdown_in_world.head<2>(),
                                aircraft.touchdown_uncertainty_m,
                                site.plan.approach->ground_roll_in_world));
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
  int num_showing = 0, num_pictures = 0;
  bool is_told = false;
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
    num_showing += row.num_shown > 0;
    is_told = is_told || row.is_told;
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

cv::Mat3b Marked(const cv::Mat3f& picture, const cv::Mat1b& is_strip, const cv::Mat1b& is_changed) {
  cv::Mat3b marked;
  picture.convertTo(marked, CV_8U);
  std::vector<std::vector<cv::Point>> outlines;
  cv::findContours(is_strip.clone(), outlines, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
  cv::drawContours(marked, outlines, -1, {255, 255, 255}, 1);
  if (!is_changed.empty()) {
    cv::findContours(is_changed.clone(), outlines, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
    cv::drawContours(marked, outlines, -1, {0, 0, 255}, 1);
  }
  return marked;
}

}  // namespace

void WriteComparison(const StripPicture& strip,
                     const WatchedPhoto& photo,
                     const WatchOptions& options,
                     const std::string& file) {
  const StripGround ground(strip);
  const auto sampling = SamplingAt(photo, ground, ExtentOf(strip).Middle());
  if (!sampling) return;
  const StripCanvas canvas = MakeCanvas(strip, *sampling, options);
  const auto registration = Register(photo, ground, canvas, options);
  const ProjectedPhoto projected = Project(
      photo, ground, canvas, registration ? registration->displacement : [](double, double) {
        return Eigen::Vector2d(0.0, 0.0);
      });
  const cv::Mat1b all(canvas.picture.size(), uchar{255});
  const StripChange change = ChangeOf(canvas, projected, all, options);
  cv::Mat1b deviations;
  const double gain = 255.0 / (2.0 * options.min_deviations);
  change.green.deviations.convertTo(deviations, CV_8U, gain);
  cv::Mat1b shade;
  change.brightness.deviations.convertTo(shade, CV_8U, gain);
  // Changes of colour green, changes of brightness red.
  cv::Mat3b grey;
  cv::merge(std::vector<cv::Mat1b>{cv::Mat1b::zeros(shade.size()), deviations, shade}, grey);
  std::vector<cv::Mat> parts{
      Marked(canvas.picture, canvas.is_strip, {}),
      Marked(projected.picture,
             canvas.is_strip,
             (change.green.deviations >= options.grow_deviations) & change.is_compared),
      grey};
  cv::Mat joined;
  cv::hconcat(parts, joined);
  cv::resize(joined, joined, {}, 2.0, 2.0, cv::INTER_NEAREST);
  cv::putText(joined,
              registration
                  ? "registered, correlation " + std::to_string(registration->correlation) +
                        ", rest " + std::to_string(registration->error_m) + " m"
                  : "not registered",
              {8, 20},
              cv::FONT_HERSHEY_SIMPLEX,
              0.5,
              {255, 255, 255});
  cv::imwrite(file, joined);
}

std::vector<WatchRow> WatchWorld(uint64_t seed,
                                 const WatchRunOptions& options,
                                 const Classifier& classifier) {
  const Scenario scenario = MakeScenario(seed, options.scenario, [](double) {});
  const EngineRun run = RunEngine({scenario.rig, scenario.frames, scenario.aircraft},
                                  PipelineOptions(),
                                  classifier,
                                  [](double, const std::string&) { return true; });
  const Evaluation& evaluation = run.evaluation;
  const auto strips = StripsOf(evaluation, scenario.aircraft, options.max_num_strips);
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
