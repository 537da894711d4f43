#include "tests/evaluation/scores/field_scores.h"

#include <algorithm>
#include <cmath>

#include "api/plan_json.h"
#include "tests/evaluation/scores/corridor.h"
#include "tests/evaluation/site_score.h"
#include "tests/evaluation/truth_run.h"

namespace freelsd {
namespace {

// Below this the wind has no direction; the final then runs east.
constexpr double kCalmMps = 1e-3;

bool IsFound(const Field& field, const EngineRun& run, const TruthMap& truth, const Fields& all) {
  const std::vector<Site>& sites = run.evaluation.sites;
  return std::any_of(sites.begin(), sites.end(), [&](const Site& site) {
    return site.plan.verdict != Verdict::kRejected &&
           FieldAt(all, truth, site.plan.touchdown_in_world.head<2>()) == field.id;
  });
}

std::string FaultsOf(const SafetyScore& score, Verdict verdict) {
  std::string faults;
  const auto add = [&](const char* place, const std::string& fault) {
    if (!fault.empty()) faults += (faults.empty() ? "" : ", ") + std::string(place) + fault;
  };
  add("ground: ", score.ground_fault);
  add("final: ", score.final_fault);
  if (verdict == Verdict::kLandable) add("loiter: ", score.loiter_fault);
  return faults;
}

struct FinalLine {
  FinalFrame frame;
  double length = 0.0;
};

FinalLine IntoWind(const Scenario& scenario, const Eigen::Vector2d& touchdown) {
  const Eigen::Vector2d& wind = scenario.world.wind_in_world;
  const bool is_calm = wind.norm() < kCalmMps;
  const Eigen::Vector2d forward =
      is_calm ? Eigen::Vector2d(Eigen::Vector2d::UnitX()) : Eigen::Vector2d(-wind.normalized());
  return {{touchdown, forward}, TrueFinalLength(scenario.world, scenario.aircraft)};
}

FinalLine LineOf(const Approach& approach) {
  const Eigen::Vector2d touchdown = approach.touchdown_in_world.head<2>();
  const Eigen::Vector2d span = touchdown - approach.approach_start_in_world.head<2>();
  return {{touchdown, span.normalized()}, span.norm()};
}

// Points 1 m apart in disc, ground roll and final. Ground outside the world counts as not seen.
double PhotographedRatio(const Scenario& scenario, const TruthMap& truth, const FinalLine& line) {
  const Aircraft& aircraft = scenario.aircraft;
  const double radius = aircraft.touchdown_uncertainty_m, half_width = aircraft.path_half_width_m;
  const int ahead = static_cast<int>(std::max(radius, aircraft.ground_roll_m));
  const int behind = static_cast<int>(std::max(radius, line.length));
  const int side = static_cast<int>(std::max(radius, half_width));
  int num_points = 0, num_seen = 0;
  for (int along = -behind; along <= ahead; ++along) {
    for (int across = -side; across <= side; ++across) {
      const bool is_on_strip = along >= -line.length && along <= aircraft.ground_roll_m &&
                               std::abs(across) <= half_width;
      if (!is_on_strip && std::hypot(along, across) > radius) continue;
      const Eigen::Vector2d place = line.frame.Place(along, across);
      ++num_points;
      if (place.cwiseAbs().maxCoeff() >= 0.5 * truth.size_m) continue;
      num_seen += scenario.seen(truth.CellAt(place)) != 0;
    }
  }
  return static_cast<double>(num_seen) / std::max(1, num_points);
}

// The planner's own answer at a place of the engine's map.
std::string AskEngine(const Scenario& scenario,
                      const EngineRun& run,
                      const Region& field,
                      const Eigen::Vector2d& place,
                      const PipelineOptions& options) {
  const ElevationMap& map = run.evaluation.map;
  if (map.elevation.empty() || !map.grid.CellAt(place)) return "no map";
  const PlanRequest request = RequestOfRun(run, scenario, field);
  const ApproachPlanner planner(
      map, run.evaluation.hazards, request, scenario.aircraft, options.approach);
  const PlaceJudgement judgement = planner.Judge(place, request.wind_in_world, options.hazard);
  const PlaceRule* failed = judgement.FirstFailed();
  const bool is_accepted = judgement.verdict != Verdict::kRejected || failed == nullptr;
  return is_accepted ? "accepted if asked" : failed->name;
}

// Of the plan on maps without error.
FieldScore ScoreOnTruth(const Scenario& scenario,
                        const TruthMap& truth,
                        const Field& field,
                        const Plan& plan) {
  FieldScore score;
  score.touchdown = field.touchdown;
  if (plan.verdict == Verdict::kRejected) {
    score.reason_on_truth = NameOf(plan.reject_reason.value());
    score.photographed_ratio =
        PhotographedRatio(scenario, truth, IntoWind(scenario, field.touchdown));
    return score;
  }
  score.is_accepted_on_truth = true;
  score.touchdown = plan.touchdown_in_world.head<2>();
  score.photographed_ratio = PhotographedRatio(scenario, truth, LineOf(plan.approach.value()));
  const SafetyScore safety =
      ScorePlan(scenario.world, truth, scenario.aircraft, plan, Eigen::Vector2d::Zero()).value();
  score.fault_on_truth = FaultsOf(safety, plan.verdict);
  score.is_only_thin_on_truth = safety.IsOnlyThin(plan.verdict);
  return score;
}

}  // namespace

int FieldAt(const Fields& fields, const TruthMap& truth, const Eigen::Vector2d& place) {
  if (place.cwiseAbs().maxCoeff() >= 0.5 * truth.size_m) return 0;
  return fields.label(truth.CellAt(place));
}

PlanRequest RequestOfRun(const EngineRun& run, const Scenario& scenario, const Region& region) {
  const std::optional<WindEstimate>& wind = run.evaluation.wind;
  PlanRequest request =
      RequestFor(region, wind ? wind->wind_in_world : scenario.world.wind_in_world);
  if (wind) request.wind_spread_mps = wind->spread_mps;
  return request;
}

std::vector<FieldScore> ScoreFields(const Scenario& scenario,
                                    const EngineRun& run,
                                    const TruthMap& truth,
                                    const Fields& fields,
                                    const PipelineOptions& options) {
  const EngineRun on_truth = RunOnTruth(scenario, truth, fields, options.approach);
  std::vector<FieldScore> scores;
  scores.reserve(fields.fields.size());
  for (size_t i = 0; i < fields.fields.size(); ++i) {
    const Site& site = on_truth.evaluation.sites[i];
    FieldScore score = ScoreOnTruth(scenario, truth, fields.fields[i], site.plan);
    score.is_found = IsFound(fields.fields[i], run, truth, fields);
    if (!score.is_found) {
      score.lost_reason = AskEngine(scenario, run, site.region, score.touchdown, options);
    }
    scores.push_back(std::move(score));
  }
  return scores;
}

}  // namespace freelsd
