#include "engine/approach/approach.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "engine/approach/approach_ground.h"
#include "engine/approach/attempt_verdict.h"
#include "engine/approach/go_around/go_around.h"
#include "engine/approach/landing_strip.h"
#include "engine/approach/path_rules.h"
#include "engine/approach/search.h"
#include "engine/approach/tightest_obstacle.h"
#include "engine/check/check.h"

namespace freelsd {
namespace {

// Each start height needs a search of its own.
constexpr size_t kMaxNumStartHeights = 10;
constexpr double kMinStartHeightRatio = 0.1;
constexpr double kMaxStartHeightRatio = 20.0;

void CheckStartHeights(const std::vector<double>& ratios, const FieldCheck& check) {
  if (ratios.empty() || ratios.size() > kMaxNumStartHeights) {
    throw std::invalid_argument("approach.start_height_ratios = " + std::to_string(ratios.size()) +
                                " numbers: must be 1 to " + std::to_string(kMaxNumStartHeights));
  }
  double least = kMinStartHeightRatio;
  for (const double ratio : ratios) {
    check.Inside("start_height_ratios", ratio, least, kMaxStartHeightRatio);
    least = ratio;
  }
}

std::vector<Rejection> Rejections(const std::vector<Attempt>& passed_over,
                                  const AttemptContext& context) {
  const auto limit = static_cast<size_t>(context.options.max_num_rejections);
  std::vector<Rejection> rejections;
  for (const Attempt& attempt : passed_over) {
    if (rejections.size() >= limit) break;
    rejections.push_back(Explain(Thorough(attempt, context), context));
  }
  return rejections;
}

// The place and its ground: everything that does not depend on the path.
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

Plan Refused(Plan plan, const Refusal& refusal) {
  plan.verdict = Verdict::kRejected;
  plan.reject_reason = refusal.reason;
  plan.reject_detail = refusal.detail;
  return plan;
}

// Adds the attempt's verdict, path and reason. Completes checks that the search stopped early.
Plan WithAttempt(Plan plan, const Attempt& attempt, const AttemptContext& context) {
  plan.verdict = attempt.verdict;
  plan.approach = DescribeApproach(attempt, context);
  if (attempt.verdict != Verdict::kRejected) return plan;
  const Rejection rejection = Explain(attempt, context);
  return Refused(std::move(plan), {rejection.reason, rejection.detail});
}

// Adds everything that only people need.
Plan Explained(Plan plan,
               const Attempt& attempt,
               const AttemptContext& context,
               const HazardLayers& hazards) {
  const std::optional<PathObstacle> on_final = TightestOf(attempt, context, PathPart::kFinal);
  const std::optional<PathObstacle> on_circle = TightestOf(attempt, context, PathPart::kCircle);
  Approach approach = DescribeApproach(attempt, context);
  const LandingStrip strip =
      MeasureStrip(approach.touchdown_in_world, approach.heading, hazards, context.aircraft);
  approach.strip = strip;
  approach.obstacle = Tighter(on_final, on_circle);
  approach.profile = MakeProfile(approach, context.surface, context.aircraft, context.options);
  plan.approach = std::move(approach);
  plan.path_rules = PathRules(attempt, context, strip, {on_final, on_circle});
  return plan;
}

std::optional<GoAround> GoAroundOf(const Attempt& attempt,
                                   const AttemptContext& context,
                                   const ElevationMap& map,
                                   const HazardLayers& hazards) {
  if (attempt.verdict == Verdict::kRejected) return std::nullopt;
  const std::vector<Approach> flown = ApproachesOf(attempt, context);
  const ClearanceSurface& planned = context.surface;
  // A plan for one region only reads the map around the region.
  if (planned.num_rows() == map.grid.num_rows && planned.num_cols() == map.grid.num_cols) {
    return FindGoAround(flown, planned, context.aircraft, context.options);
  }
  return FindGoAround(
      flown,
      MakeClimbSurface(flown.front(), map, hazards, context.aircraft, context.options),
      context.aircraft,
      context.options);
}

// Rejected sites come after all others, the least risky first.
Plan WithRiskOf(const Attempt& attempt, Plan plan, const AttemptContext& context) {
  constexpr double kLargestRejectedScore = 0.2;
  const double limit = context.risk.max_failure_probability;
  plan.risk = RiskOf(attempt, context);
  plan.path_rules.push_back(RiskRule(*plan.risk, limit));
  const double success = 1.0 - plan.risk->failure_probability;
  plan.score = plan.verdict == Verdict::kRejected ? kLargestRejectedScore * success : success;
  return plan;
}

// Adds a rejection with the reason why the first search failed.
Plan InsteadOf(const Plan& first, Plan plan, const ApproachOptions& options) {
  const auto limit = static_cast<size_t>(options.max_num_rejections);
  plan.rejections.insert(
      plan.rejections.begin(),
      {first.touchdown_in_world, *first.reject_reason, first.reject_detail, std::nullopt});
  if (plan.rejections.size() > limit) plan.rejections.resize(limit);
  return plan;
}

}  // namespace

void ApproachOptions::Check() const {
  const FieldCheck check("approach");
  check.Inside("min_map_position_sd_m", min_map_position_sd_m, 0.0, 100.0);
  check.Inside("unclear_height_allowance_m", unclear_height_allowance_m, 0.0, 100.0);
  check.Inside("max_height_sd_m", max_height_sd_m, 0.01, 100.0);
  check.Inside("tilt_sigma", tilt_sigma, 0.0, 10.0);
  check.Inside("bare_ground_radius_m", bare_ground_radius_m, 0.0, 20.0);
  check.Inside("max_bare_roughness_m", max_bare_roughness_m, 0.0, 10.0);
  check.Inside("max_crosswind_ratio", max_crosswind_ratio, 0.0, 1.0);
  check.Inside("unknown_wind_mps", unknown_wind_mps, 0.0, 100.0);
  check.Inside("wind_sigma", wind_sigma, 0.0, 10.0);
  check.Inside("disc_margin_sigma", disc_margin_sigma, 0.0, 10.0);
  check.Inside("path_margin_sigma", path_margin_sigma, 0.0, 10.0);
  check.Inside("max_num_candidates", max_num_candidates, 1.0, 1e6);
  check.Inside("max_num_reserve_candidates", max_num_reserve_candidates, 0.0, 1e6);
  check.Inside("candidate_spacing_m", candidate_spacing_m, 0.0, 1000.0);
  check.Inside("heading_step_deg", heading_step_deg, 1.0, 180.0);
  check.Inside("calm_wind_mps", calm_wind_mps, 0.0, 10.0);
  check.Inside("path_step_m", path_step_m, 0.05, 5.0);
  check.Inside("max_num_rejections", max_num_rejections, 0.0, 1e6);
  risk.Check();
  CheckStartHeights(start_height_ratios, check);
}

Plan ApproachGround::PlanWay(const Way& way, Explanation explanation) const {
  std::optional<Refusal> why_not = refusal;
  if (!why_not) why_not = RefuseWind(way.wind, way.aircraft);
  if (why_not) {
    return Refused(PlanAt(safest, hazards, request, way.aircraft), *why_not);
  }
  const std::vector<WindScenario> scenarios = way.Scenarios();
  std::optional<ClearanceSurface> about_here;
  if (!surface || surface->circle_step != CircleStep(scenarios, options)) {
    about_here =
        MakeClearanceSurface(map, hazards, request.footprint, scenarios, way.aircraft, options);
  }
  const ClearanceSurface& to_clear = about_here ? *about_here : *surface;
  const std::vector<HeadingCells> cells =
      MakeHeadingCells(way.wind, to_clear, way.aircraft, options);
  const AttemptContext context{to_clear, way.wind, way.aircraft, options, cells, *risk};
  const SearchResult found = SearchTouchdown(candidates, context);
  const Attempt best = Thorough(found.best, context);
  Plan plan = WithAttempt(PlanAt(best.touchdown, hazards, request, way.aircraft), best, context);
  if (explanation == Explanation::kFull) {
    plan = Explained(std::move(plan), best, context, hazards);
    plan.approach->go_around = GoAroundOf(best, context, map, hazards);
    plan.rejections = Rejections(found.passed_over, context);
    plan = WithRiskOf(best, std::move(plan), context);
  }
  return plan;
}

ApproachGround::ApproachGround(const ElevationMap& the_map,
                               const HazardLayers& the_hazards,
                               const PlanRequest& the_request,
                               const Aircraft& the_aircraft,
                               const ApproachOptions& the_options)
    : map(the_map),
      hazards(the_hazards),
      request(the_request),
      profile(the_aircraft),
      options(the_options) {
  RequireOneGrid(map, hazards);
  aircraft = WithPositionMargin(profile, map, options);
  risk.reset(new RiskBasis{RiskAssessor(map, hazards, profile, options.risk),
                           request.wind_spread_mps,
                           PositionDeviation(map, options),
                           profile.max_failure_probability});
  required_hazard_distance = RequiredHazardDistance(map, aircraft, options);
  const FootprintContent content = ReadFootprint(map, hazards, request.footprint);
  if (!content.touchdowns.empty()) safest = content.touchdowns.front();
  refusal_of_region = RefuseRegion(request, content, aircraft);
  refusal = RefuseGround(request, content, required_hazard_distance, aircraft);
  candidates =
      SelectCandidates(content.touchdowns, required_hazard_distance, map.grid.cell_size_m, options);
}

Plan ApproachGround::PlanWind(const std::optional<Eigen::Vector2d>& wind_in_world,
                              Explanation explanation) const {
  // A wind that was not measured here has no spread.
  const bool is_measured = wind_in_world && wind_in_world == request.wind_in_world;
  const double wind_margin = is_measured ? options.wind_sigma * request.wind_spread_mps : 0.0;
  std::optional<Plan> first;
  bool is_loiter_blocked = false;
  for (const Way& way : WaysDown(wind_in_world, aircraft, options, wind_margin)) {
    if (way.start_height > 0 && !is_loiter_blocked) break;
    Plan plan = PlanWay(way, explanation);
    if (plan.verdict != Verdict::kRejected) {
      const bool is_told = first && explanation == Explanation::kFull;
      return is_told ? InsteadOf(*first, std::move(plan), options) : plan;
    }
    is_loiter_blocked |= plan.reject_reason == RejectReason::kLoiterBlocked;
    if (!first) first = std::move(plan);
    if (!first->approach) break;
  }
  return *std::move(first);
}

ApproachPlanner::ApproachPlanner(const ElevationMap& map,
                                 const HazardLayers& hazards,
                                 const PlanRequest& request,
                                 const Aircraft& aircraft,
                                 const ApproachOptions& options) {
  auto ground = std::make_unique<ApproachGround>(map, hazards, request, aircraft, options);
  if (!ground->refusal) {
    ground->surface = MakeClearanceSurfaceOfMap(map, hazards, ground->aircraft, options);
  }
  ground_ = std::move(ground);
}

ApproachPlanner::~ApproachPlanner() = default;
ApproachPlanner::ApproachPlanner(ApproachPlanner&&) noexcept = default;
ApproachPlanner& ApproachPlanner::operator=(ApproachPlanner&&) noexcept = default;

Plan ApproachPlanner::PlanFor(const std::optional<Eigen::Vector2d>& wind_in_world,
                              Explanation explanation) const {
  return ground_->PlanWind(wind_in_world, explanation);
}

Plan PlanApproach(const ElevationMap& map,
                  const HazardLayers& hazards,
                  const PlanRequest& request,
                  const Aircraft& aircraft,
                  const ApproachOptions& options) {
  return ApproachGround(map, hazards, request, aircraft, options)
      .PlanWind(request.wind_in_world, Explanation::kFull);
}

}  // namespace freelsd
