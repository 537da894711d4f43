#include "tests/evaluation/ablation/ablation.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "api/flight_parts.h"
#include "tests/evaluation/scores/field_scores.h"
#include "tests/evaluation/scores/flown_site.h"
#include "tests/evaluation/scores/landing_risks.h"
#include "tests/evaluation/scores/things.h"
#include "tests/evaluation/site_score.h"
#include "tests/evaluation/stage_scores.h"
#include "tests/evaluation/statistics.h"
#include "tests/synthetic/noise.h"

namespace freelsd {
namespace {

using Json = nlohmann::json;

constexpr const char* kNothing = "none";
const std::string kFreeCells = "free cells: ";

// The aircraft and the engine's options without a step.
struct Settings {
  Aircraft aircraft;
  PipelineOptions options;
};

Settings SettingsWithout(const Json& step, const Json& engine_options, const Aircraft& aircraft) {
  Json options = engine_options;
  if (step.contains("options")) options.merge_patch(step.at("options"));
  Json given{{"profile", aircraft.profile}};
  if (step.contains("aircraft")) given.merge_patch(step.at("aircraft"));
  Settings settings{ParseAircraft(given, "/aircraft"), ParseOptions(options, "/options")};
  settings.options.regions.min_area_m2 = aircraft.min_area_m2;
  return settings;
}

EngineRun RunWithout(const Scenario& scenario, const EngineRun& run, const Settings& settings) {
  std::map<std::string, cv::Mat> images;
  for (const Frame& frame : scenario.frames) images[frame.id] = frame.image;
  std::vector<Candidate> graded;
  std::copy_if(run.snapshot.regions.begin(),
               run.snapshot.regions.end(),
               std::back_inserter(graded),
               [](const Candidate& candidate) { return candidate.region.grade > 0.0; });
  EngineRun without;
  without.evaluation = EvaluateSites(run.snapshot,
                                     {std::move(graded), PhotographedArea(run.snapshot)},
                                     [&images](const std::string& id) { return images.at(id); },
                                     settings.aircraft,
                                     settings.options,
                                     {});
  return without;
}

void CountSites(const Scenario& scenario,
                const TruthMap& truth,
                const Fields& fields,
                const EngineRun& run,
                uint64_t seed,
                Json& counts) {
  std::set<int> found;
  int num_accepted = 0, num_false_safe = 0, num_only_thin = 0, num_flown = 0, num_failed = 0;
  for (const Site& site : run.evaluation.sites) {
    const Verdict verdict = site.plan.verdict;
    if (verdict == Verdict::kRejected) continue;
    found.insert(FieldAt(fields, truth, site.plan.touchdown_in_world.head<2>()));
    const auto score =
        ScorePlan(scenario.world, truth, scenario.aircraft, site.plan, Eigen::Vector2d::Zero());
    if (score->IsInDoubt(verdict)) continue;
    const FlownSite flown =
        FlySite(scenario.world, truth, scenario.aircraft, site, MixSeed(seed, num_accepted));
    ++num_accepted;
    num_only_thin += score->IsOnlyThin(verdict);
    num_false_safe += score->IsFalseSafe(verdict) && !score->IsOnlyThin(verdict);
    num_flown += flown.num_flown;
    num_failed += flown.num_failed;
  }
  const auto num_found =
      std::count_if(fields.fields.begin(), fields.fields.end(), [&](const Field& field) {
        return field.is_landable && field.num_seen_touchdowns > 0 && found.contains(field.id);
      });
  counts["num_found"] = num_found;
  counts["num_accepted"] = num_accepted;
  counts["num_false_safe"] = num_false_safe;
  counts["num_only_thin"] = num_only_thin;
  counts["num_flown"] = num_flown;
  counts["num_failed"] = num_failed;
}

void CountLandings(const std::vector<DrawnLanding>& landings,
                   const EngineRun& run,
                   const Aircraft& aircraft,
                   const ApproachOptions& options,
                   Json& counts) {
  int num_landings = 0;
  double loss = 0.0, loss_of_all = 0.0;
  for (const DrawnLanding& landing : landings) {
    const std::optional<LandingRisk> risk = RiskAt(landing.site, run, aircraft, options);
    if (!risk) continue;
    ++num_landings;
    loss += LogLoss(risk->failure_probability, landing.observed);
    loss_of_all += LogLoss(landing.risk.failure_probability, landing.observed);
  }
  counts["num_landings"] = num_landings;
  counts["log_loss"] = loss;
  counts["log_loss_of_all"] = loss_of_all;
}

MapOffset OffsetOf(const Scenario& scenario, const TruthMap& truth, const EngineRun& run) {
  return OffsetOfMap(scenario.world,
                     truth,
                     run.evaluation.map,
                     ScoreMap(run, scenario, truth).detilted.plane,
                     ScorePoses(run, scenario).shift.head<2>());
}

// Things that the map does not show, as ThingFate says.
void CountMissedThings(const Scenario& scenario,
                       const EngineRun& run,
                       const MapOffset& offset,
                       Json& counts) {
  const ThingScores things =
      ScoreThings(scenario, run.evaluation.map, run.evaluation.hazards, offset);
  counts["num_missed_things"] = things.missed.size();
}

// Cells of each true kind that the map calls free.
void CountFreeCells(const Scenario& scenario,
                    const TruthMap& truth,
                    const EngineRun& run,
                    Json& counts) {
  for (const auto& [kind, cells] : ScoreMap(run, scenario, truth).hazard_of_kind) {
    counts[kFreeCells + kind] = cells[kFree];
  }
}

// What all steps are compared on.
struct Basis {
  const Scenario& scenario;
  const TruthMap& truth;
  const Fields& fields;
  uint64_t seed = 0;
  std::vector<DrawnLanding> landings;
  MapOffset offset;
};

Json Count(const Basis& basis, const EngineRun& run, const Settings& settings) {
  Json counts = Json::object();
  CountSites(basis.scenario, basis.truth, basis.fields, run, basis.seed, counts);
  CountLandings(basis.landings, run, settings.aircraft, settings.options.approach, counts);
  CountMissedThings(basis.scenario, run, basis.offset, counts);
  CountFreeCells(basis.scenario, basis.truth, run, counts);
  return counts;
}

}  // namespace

Json CountAblations(const Scenario& scenario,
                    const TruthMap& truth,
                    const Fields& fields,
                    const EngineRun& run,
                    const Ablations& ablations,
                    uint64_t seed) {
  const Settings whole =
      SettingsWithout(Json::object(), ablations.engine_options, scenario.aircraft);
  const Basis basis{scenario,
                    truth,
                    fields,
                    seed,
                    DrawLandings(run, scenario, truth, whole.options.approach, seed),
                    OffsetOf(scenario, truth, run)};
  Json json{{kNothing, Count(basis, run, whole)}};
  for (const auto& [name, step] : ablations.steps.items()) {
    const Settings settings = SettingsWithout(step, ablations.engine_options, scenario.aircraft);
    json[name] = Count(basis, RunWithout(scenario, run, settings), settings);
  }
  return json;
}

Json AblationTotals(const Json& records) {
  std::map<std::string, std::map<std::string, double>> totals;
  for (const Json& record : records) {
    if (!record.contains("ablations")) continue;
    for (const auto& [name, counts] : record.at("ablations").items()) {
      for (const auto& [key, count] : counts.items()) totals[name][key] += count.get<double>();
    }
  }
  Json json = Json::object();
  for (auto& [name, counts] : totals) {
    const double num_landings = std::max(1.0, counts.at("num_landings"));
    const double change = (counts.at("log_loss") - counts.at("log_loss_of_all")) / num_landings;
    const double failed = counts.at("num_failed") / std::max(1.0, counts.at("num_flown"));
    json[name] = {{"num_found", counts.at("num_found")},
                  {"num_accepted", counts.at("num_accepted")},
                  {"num_false_safe", counts.at("num_false_safe")},
                  {"num_only_thin", counts.at("num_only_thin")},
                  {"failure_ratio", RoundedNumber(failed)},
                  {"num_missed_things", counts.at("num_missed_things")},
                  {"num_landings", counts.at("num_landings")},
                  {"log_loss_change", RoundedNumber(change)}};
    for (const auto& [key, count] : counts) {
      if (key.starts_with(kFreeCells)) json[name][key.substr(kFreeCells.size())] = count;
    }
  }
  return json;
}

}  // namespace freelsd
