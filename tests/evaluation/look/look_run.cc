#include "tests/evaluation/look/look_run.h"

#include <algorithm>
#include <map>
#include <random>
#include <utility>
#include <vector>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "tests/evaluation/pictures.h"
#include "tests/evaluation/site_score.h"
#include "tests/synthetic/noise.h"

namespace freelsd {
namespace {

using Json = nlohmann::json;

constexpr uint64_t kPairsPurpose = 602;

// A world, and what is needed to fly over it and to judge the result.
struct LookBench {
  const LookWorld& world;
  const LookRunOptions& options;
  const Classifier& classifier;
  TruthMap truth;

  EngineRun RunWith(const std::vector<std::vector<Frame>>& legs) const {
    std::vector<Frame> frames = world.survey();
    for (const std::vector<Frame>& leg : legs) frames.insert(frames.end(), leg.begin(), leg.end());
    const Scenario& scenario = world.scenario();
    PipelineOptions engine;
    engine.regions.min_area_m2 = scenario.aircraft.min_area_m2;
    return RunEngine(
        {scenario.rig, frames, scenario.aircraft}, engine, classifier, [](double, auto&) {
          return true;
        });
  }
  Json Outcome(const EngineRun& run) const {
    return OutcomeOf(run, world.scenario(), truth, options.look.unverified_value);
  }
};

std::vector<SiteSoFar> SitesSoFar(const std::vector<Site>& sites) {
  std::vector<SiteSoFar> so_far;
  for (const Site& site : sites) {
    SiteSoFar each{site.plan.verdict, site.plan.touchdown_in_world};
    if (site.plan.approach) {
      const Approach& approach = *site.plan.approach;
      PlannedLanding landing;
      landing.touchdown_in_world = approach.touchdown_in_world;
      landing.heading = approach.heading;
      landing.approach_distance = approach.approach_distance;
      landing.approach_height = approach.approach_height;
      landing.loiter_center_in_world = approach.loiter_center_in_world.head<2>();
      landing.loiter_radius = approach.loiter_radius;
      each.landing = landing;
    }
    so_far.push_back(each);
  }
  return so_far;
}

NextLook Suggest(const LookBench& bench, const EngineRun& before) {
  const Evaluation& evaluation = before.evaluation;
  const std::vector<SiteSoFar> sites = SitesSoFar(evaluation.sites);
  std::vector<Rigid3d> flown;
  for (const AdjustedView& view : evaluation.block.views) {
    if (view.is_connected) flown.push_back(view.world_from_camera);
  }
  LookRequest request{.map = evaluation.map,
                      .layers = evaluation.hazards,
                      .num_views = evaluation.num_views,
                      .sites = sites,
                      .rig = bench.world.scenario().rig,
                      .flown = flown,
                      .aircraft = bench.world.scenario().aircraft};
  if (evaluation.wind) request.wind_in_world = evaluation.wind->wind_in_world;
  request.area = bench.world.area();
  return ChooseNextLook(request, bench.options.look);
}

// Different pairs of so many legs.
std::vector<std::pair<int, int>> DrawPairs(uint64_t seed, int num_legs, int num_pairs) {
  std::vector<std::pair<int, int>> pairs;
  for (int i = 0; i < num_legs; ++i) {
    for (int j = i + 1; j < num_legs; ++j) pairs.emplace_back(i, j);
  }
  std::mt19937_64 random(MixSeed(seed, kPairsPurpose));
  std::shuffle(pairs.begin(), pairs.end(), random);
  pairs.resize(std::min(pairs.size(), static_cast<size_t>(num_pairs)));
  return pairs;
}

// North up, as DrawWorld has it: so many pixels per metre.
void DrawLegs(const std::string& path, const std::vector<SyntheticLeg>& legs, double size_m) {
  constexpr double kPixelsPerMetreOfPicture = 1.8;
  cv::Mat picture = cv::imread(path);
  const auto pixel = [&](const Eigen::Vector2d& place) {
    return cv::Point(static_cast<int>((place.x() + 0.5 * size_m) * kPixelsPerMetreOfPicture),
                     static_cast<int>((0.5 * size_m - place.y()) * kPixelsPerMetreOfPicture));
  };
  for (const SyntheticLeg& leg : legs) {
    cv::arrowedLine(picture, pixel(leg.from), pixel(leg.to), {255, 120, 0}, 3, cv::LINE_AA);
  }
  cv::imwrite(path, picture);
}

void Draw(const LookBench& bench,
          const std::string& name,
          const EngineRun& run,
          const std::vector<SyntheticLeg>& legs) {
  const std::string& folder = bench.options.pictures;
  if (folder.empty()) return;
  const Scenario& scenario = bench.world.scenario();
  const Fields fields = FindFields(scenario.world, bench.truth, scenario.aircraft, scenario.seen);
  DrawWorld(folder, name, scenario, run, bench.truth, fields);
  for (const char* const kind : {"-world.png", "-hazard.png", "-truth.png"}) {
    DrawLegs(folder + "/" + name + kind, legs, scenario.world.size_m);
  }
}

Json FlySuggested(const LookBench& bench, const EngineRun& before, const std::string& name) {
  const NextLook look = Suggest(bench, before);
  std::vector<SyntheticLeg> legs;
  std::vector<std::vector<Frame>> photographs;
  for (const LookLeg& leg : look.legs) {
    const int id = bench.options.world.num_survey_legs + bench.options.num_random_legs +
                   static_cast<int>(legs.size());
    legs.push_back({leg.from_in_world.head<2>(), leg.to_in_world.head<2>(), id});
    photographs.push_back(bench.world.Photograph(legs.back()));
  }
  const EngineRun after = bench.RunWith(photographs);
  Draw(bench, name + "-before", before, legs);
  Draw(bench, name + "-after", after, legs);
  Json outcome = bench.Outcome(after);
  outcome["expected_gain"] = look.expected_gain;
  outcome["num_legs"] = look.legs.size();
  return outcome;
}

Json FlyRandom(const LookBench& bench, uint64_t seed) {
  // Several pairs share a leg.
  std::map<int, std::vector<Frame>> legs;
  Json outcomes = Json::array();
  for (const auto& [first, second] :
       DrawPairs(seed, bench.options.num_random_legs, bench.options.num_random_pairs)) {
    for (const int leg : {first, second}) {
      if (!legs.contains(leg)) legs[leg] = bench.world.Photograph(bench.world.RandomLeg(leg));
    }
    outcomes.push_back(bench.Outcome(bench.RunWith({legs[first], legs[second]})));
  }
  return outcomes;
}

}  // namespace

Json OutcomeOf(const EngineRun& run,
               const Scenario& scenario,
               const TruthMap& truth,
               double unverified_value) {
  double landing_value = 0.0;
  int num_landable = 0, num_unverified = 0, num_false_safe = 0, num_only_thin = 0;
  for (const Site& site : run.evaluation.sites) {
    const Verdict verdict = site.plan.verdict;
    if (verdict == Verdict::kRejected) continue;
    const auto score =
        ScorePlan(scenario.world, truth, scenario.aircraft, site.plan, Eigen::Vector2d::Zero());
    if (score->IsFalseSafe(verdict)) {
      num_only_thin += score->IsOnlyThin(verdict);
      num_false_safe += !score->IsOnlyThin(verdict);
      continue;
    }
    num_landable += verdict == Verdict::kLandable;
    num_unverified += verdict == Verdict::kUnverified;
    landing_value += verdict == Verdict::kLandable ? 1.0 : unverified_value;
  }
  return {{"landing_value", landing_value},
          {"num_landable", num_landable},
          {"num_unverified", num_unverified},
          {"num_false_safe", num_false_safe},
          {"num_only_thin", num_only_thin}};
}

Json RunLook(uint64_t seed, const LookRunOptions& options, const Classifier& classifier) {
  const LookWorld world(seed, options.world);
  const LookBench bench{
      world, options, classifier, MakeTruthMap(world.scenario().world, world.scenario().aircraft)};
  const EngineRun before = bench.RunWith({});
  Json record{{"seed", seed},
              {"aircraft", world.scenario().aircraft.profile},
              {"before", bench.Outcome(before)}};
  record["suggested"] = FlySuggested(bench, before, std::to_string(seed));
  record["random"] = FlyRandom(bench, seed);
  return record;
}

}  // namespace freelsd
