#include "engine/approach/approach.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <stdexcept>

#include "engine/approach/attempt.h"
#include "engine/approach/score.h"

namespace freelsd {
namespace {

struct Refusal {
  RejectReason reason = RejectReason::kNoTerrain;
  std::string detail;
};

// What the search over the candidates found.
struct SearchResult {
  std::optional<Attempt> best;
  std::vector<Rejection> rejections;
};

std::string Rounded(double value, int num_decimals) {
  std::ostringstream text;
  text.setf(std::ios::fixed);
  text.precision(num_decimals);
  text << value;
  return text.str();
}

void RequireOneGrid(const ElevationMap& map, const HazardLayers& hazards) {
  const cv::Size size(map.grid.num_cols, map.grid.num_rows);
  const bool is_whole = map.elevation.size() == size && map.upper.size() == size &&
                        hazards.slope.size() == size && hazards.roughness.size() == size &&
                        hazards.grass.size() == size && hazards.hazard.size() == size &&
                        hazards.distance.size() == size && map.standard_deviation.size() == size;
  if (map.grid == hazards.grid && is_whole) return;
  throw std::invalid_argument("approach.hazards: must be of the map's grid, " +
                              std::to_string(size.height) + "x" + std::to_string(size.width) +
                              " cells");
}

// Reasons that speak against the region itself, in the order of the paper's stages.
std::optional<Refusal> RefuseRegion(const PlanRequest& request,
                                    const FootprintContent& content,
                                    const Aircraft& aircraft) {
  if (!(request.area_m2 >= aircraft.min_area_m2)) {
    return Refusal{RejectReason::kTooSmall,
                   "the region has " + Rounded(request.area_m2, 0) + " m2, " +
                       Rounded(aircraft.min_area_m2, 0) + " m2 are needed"};
  }
  if (request.num_observations < request.min_num_observations) {
    return Refusal{RejectReason::kTooFewObservations,
                   "the region was seen in " + std::to_string(request.num_observations) +
                       " images, " + std::to_string(request.min_num_observations) + " are needed"};
  }
  if (!(request.grade > 0.0)) {
    return Refusal{RejectReason::kNotGrass, "the region was never seen as grass"};
  }
  if (content.touchdowns.empty()) {
    return Refusal{RejectReason::kNoTerrain, "no ground within the region could be reconstructed"};
  }
  if (!content.has_grass) {
    return Refusal{RejectReason::kNotGrass, "no ground within the region is grass on the map"};
  }
  return std::nullopt;
}

std::optional<Refusal> RefuseTouchdown(const FootprintContent& content, double required_distance) {
  const double largest = content.touchdowns.front().hazard_distance;
  if (largest >= required_distance) return std::nullopt;
  return Refusal{RejectReason::kNoSafeTouchdown,
                 "the place farthest from hazard is " + Rounded(largest, 1) + " m from it, " +
                     Rounded(required_distance, 1) + " m are needed"};
}

std::optional<Refusal> RefuseWind(const WindCase& wind) {
  if (!wind.is_too_strong) return std::nullopt;
  return Refusal{
      RejectReason::kWindTooStrong,
      "against " + Rounded(wind.wind_speed, 1) + " m/s of wind the aircraft makes no way on final"};
}

// Sec. III-H: from the safest touchdown on, the first free one wins.
SearchResult Search(const std::vector<Touchdown>& candidates, const AttemptContext& context) {
  SearchResult result;
  std::vector<Attempt> passed_over;
  for (const Touchdown& candidate : candidates) {
    const Attempt attempt = BestHeading(candidate, context);
    const bool is_first_free = attempt.verdict != Verdict::kRejected &&
                               (!result.best || attempt.verdict < result.best->verdict);
    const bool is_least_bad =
        attempt.verdict == Verdict::kRejected && (!result.best || IsBetter(attempt, *result.best));
    if (is_first_free || is_least_bad) result.best = attempt;
    if (attempt.verdict == Verdict::kLandable) break;
    if (attempt.verdict == Verdict::kUnverified && !context.wind.is_known) break;
    passed_over.push_back(attempt);
  }
  const auto limit = static_cast<size_t>(context.options.max_num_rejections);
  for (const Attempt& attempt : passed_over) {
    // What comes after the chosen one is not better; unless none was good.
    const bool is_chosen = result.best->touchdown.row == attempt.touchdown.row &&
                           result.best->touchdown.col == attempt.touchdown.col;
    if (is_chosen && attempt.verdict != Verdict::kRejected) break;
    if (result.rejections.size() >= limit) break;
    const Attempt whole = Try(attempt.touchdown, attempt.heading, context, Depth::kEverything);
    result.rejections.push_back(Explain(whole, context));
  }
  return result;
}

// Place and its ground; everything that does not depend on the path.
Plan PlanAt(const std::optional<Touchdown>& touchdown,
            const HazardLayers& hazards,
            const PlanRequest& request,
            const Aircraft& aircraft) {
  Plan plan;
  plan.slope = plan.roughness = std::numeric_limits<double>::quiet_NaN();
  if (!touchdown) {
    const Eigen::Vector2d middle =
        request.footprint.empty() ? Eigen::Vector2d::Zero() : Centroid(request.footprint);
    plan.touchdown_in_world = {middle.x(), middle.y(), request.ground_height};
    return plan;
  }
  const double radius = aircraft.touchdown_uncertainty_m, cell = hazards.grid.cell_size_m;
  plan.touchdown_in_world = touchdown->place_in_world;
  plan.hazard_distance = touchdown->hazard_distance;
  plan.slope = LargestInDisc(hazards.slope, *touchdown, radius, cell);
  plan.roughness = LargestInDisc(hazards.roughness, *touchdown, radius, cell);
  return plan;
}

ScoreInput ScoreInputOf(const Plan& plan, const std::optional<Attempt>& attempt, double required) {
  ScoreInput input{.hazard_distance = plan.hazard_distance,
                   .required_hazard_distance = required,
                   .slope = plan.slope,
                   .roughness = plan.roughness};
  if (!attempt) return input;
  input.clearance_ratio =
      std::min(attempt->final_path.min_clearance_ratio, attempt->circle.min_clearance_ratio);
  input.unseen_ratio = attempt->circle.UnseenRatio();
  return input;
}

Plan Refused(Plan plan, const Refusal& refusal) {
  plan.verdict = Verdict::kRejected;
  plan.reject_reason = refusal.reason;
  plan.reject_detail = refusal.detail;
  return plan;
}

// The attempt's verdict, path and reason; its checks are completed where the search stopped early.
Plan WithAttempt(Plan plan, const Attempt& attempt, const AttemptContext& context) {
  plan.verdict = attempt.verdict;
  plan.approach = DescribeApproach(attempt, context);
  if (attempt.verdict != Verdict::kRejected) return plan;
  const Rejection rejection = Explain(attempt, context);
  return Refused(std::move(plan), {rejection.reason, rejection.detail});
}

}  // namespace

Plan PlanApproach(const ElevationMap& map,
                  const HazardLayers& hazards,
                  const PlanRequest& request,
                  const Aircraft& aircraft,
                  const ApproachOptions& options) {
  RequireOneGrid(map, hazards);
  const WindCase wind = MakeWindCase(request.wind_in_world, aircraft, options);
  const double required = RequiredHazardDistance(map, aircraft, options);
  const FootprintContent content = ReadFootprint(map, hazards, request.footprint, options);
  std::optional<Refusal> refusal = RefuseRegion(request, content, aircraft);
  if (!refusal) refusal = RefuseTouchdown(content, required);
  if (!refusal) refusal = RefuseWind(wind);
  std::optional<Touchdown> touchdown;
  if (!content.touchdowns.empty()) touchdown = content.touchdowns.front();
  if (refusal) {
    Plan plan = Refused(PlanAt(touchdown, hazards, request, aircraft), *refusal);
    plan.score_terms =
        ScoreTerms(ScoreInputOf(plan, std::nullopt, required), request, aircraft, options);
    plan.score = Score(plan.score_terms, plan.verdict);
    return plan;
  }
  const ClearanceSurface surface =
      MakeClearanceSurface(map, hazards, request.footprint, wind.scenarios, aircraft, options);
  const AttemptContext context{surface, wind, aircraft, options};
  const SearchResult found = Search(
      TouchdownCandidates(content.touchdowns, required, map.grid.cell_size_m, options), context);
  const Attempt best = Try(found.best->touchdown, found.best->heading, context, Depth::kEverything);
  Plan plan = WithAttempt(PlanAt(best.touchdown, hazards, request, aircraft), best, context);
  plan.rejections = found.rejections;
  plan.score_terms = ScoreTerms(ScoreInputOf(plan, best, required), request, aircraft, options);
  plan.score = Score(plan.score_terms, plan.verdict);
  return plan;
}

}  // namespace freelsd
