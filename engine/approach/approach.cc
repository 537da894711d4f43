#include "engine/approach/approach.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include "engine/approach/candidates.h"
#include "engine/approach/clearance.h"
#include "engine/approach/flight_path.h"
#include "engine/approach/score.h"

namespace freelsd {
namespace {

constexpr size_t kNumScoreTerms = 6;

// One candidate from one side: how far it got.
struct Attempt {
  Candidate candidate;
  Approach approach;
  Verdict verdict = Verdict::kRejected;
  std::optional<Rejection> rejection;
  // How many of the checks it passed, then by how little it failed: the least bad is kept.
  int num_passed = 0;
  double shortage = 0.0;
};

template <typename... Values>
std::string Sentence(const char* format, Values... values) {
  char text[256];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

Attempt Refused(Attempt attempt,
                RejectReason reason,
                std::string detail,
                const std::optional<Eigen::Vector3d>& obstacle) {
  attempt.verdict = Verdict::kRejected;
  attempt.rejection =
      Rejection{attempt.candidate.touchdown_in_world, reason, std::move(detail), obstacle};
  return attempt;
}

std::string DescribeFinal(const FinalCheck& check, const Approach& approach) {
  const double path_height = approach.touchdown_in_world.z() +
                             approach.approach_height * check.distance / approach.approach_distance;
  if (*check.reason == RejectReason::kApproachUnseen) {
    return Sentence("the ground under the final was not seen %.0f m before touchdown",
                    check.distance);
  }
  const double over = check.place_in_world.z() - path_height;
  return Sentence("%.0f m before touchdown the final passes %.1f m %s what stands there",
                  check.distance,
                  std::abs(over),
                  over > 0.0 ? "below the top of" : "above, less than the margin over,");
}

// The better circle: clear and seen, then clear with the least unseen; nothing if both are blocked.
std::optional<LoiterDirection> BetterCircle(const CircleCheck& left, const CircleCheck& right) {
  if (left.is_blocked && right.is_blocked) return std::nullopt;
  if (left.is_blocked) return LoiterDirection::kRight;
  if (right.is_blocked) return LoiterDirection::kLeft;
  if (left.unseen_ratio != right.unseen_ratio) {
    return left.unseen_ratio < right.unseen_ratio ? LoiterDirection::kLeft
                                                  : LoiterDirection::kRight;
  }
  return left.min_clearance >= right.min_clearance ? LoiterDirection::kLeft
                                                   : LoiterDirection::kRight;
}

// Checks of one region on one map share these.
class Planner {
 public:
  Planner(const ElevationMap& map,
          const HazardLayers& hazards,
          const PlanRequest& request,
          const Aircraft& aircraft,
          const ApproachOptions& options)
      : map_(map),
        hazards_(hazards),
        request_(request),
        aircraft_(aircraft),
        options_(options),
        surface_(MakeObstacleSurface(map, hazards, aircraft, options)) {}

  Attempt Try(const Candidate& candidate, double heading) const {
    Attempt attempt;
    attempt.candidate = candidate;
    const double wind_speed = request_.wind_in_world ? request_.wind_in_world->norm() : 0.0;
    const Leg leg{candidate.touchdown_in_world, heading, wind_speed};
    const std::optional<Approach> approach = ApproachOf(leg, aircraft_);
    if (!approach) {
      return Refused(attempt,
                     RejectReason::kWindTooStrong,
                     Sentence("%.1f m/s of wind leave no final at %.1f m/s of airspeed",
                              wind_speed,
                              aircraft_.landing_airspeed_mps),
                     std::nullopt);
    }
    attempt.approach = *approach;
    attempt.num_passed = 1;
    if (const auto hazard = HazardOnStrip(map_, hazards_, leg, aircraft_)) {
      const double along = (*hazard - candidate.touchdown_in_world).head<2>().norm();
      attempt.shortage = aircraft_.ground_roll_m - along;
      return Refused(attempt,
                     RejectReason::kNoSafeTouchdown,
                     Sentence("the ground roll of %.0f m meets a hazard after %.0f m",
                              aircraft_.ground_roll_m,
                              along),
                     hazard);
    }
    attempt.num_passed = 2;
    return TryFinal(std::move(attempt));
  }

 private:
  Attempt TryFinal(Attempt attempt) const {
    FinalCheck check = CheckFinal(surface_, attempt.approach, aircraft_, options_);
    attempt.approach.min_clearance = check.min_clearance;
    attempt.approach.profile = std::move(check.profile);
    attempt.approach.loiter_center_in_world =
        LoiterCenter(attempt.approach, attempt.approach.loiter_direction);
    attempt.approach.unseen_ratio = 1.0;
    if (check.reason) {
      attempt.shortage = check.worst_shortage;
      return Refused(
          attempt, *check.reason, DescribeFinal(check, attempt.approach), check.place_in_world);
    }
    attempt.num_passed = 3;
    return TryCircles(std::move(attempt));
  }

  Attempt TryCircles(Attempt attempt) const {
    const CircleCheck left =
        CheckCircle(surface_, attempt.approach, LoiterDirection::kLeft, aircraft_, options_);
    const CircleCheck right =
        CheckCircle(surface_, attempt.approach, LoiterDirection::kRight, aircraft_, options_);
    const std::optional<LoiterDirection> direction = BetterCircle(left, right);
    if (!direction) {
      const CircleCheck& better = left.min_clearance > right.min_clearance ? left : right;
      attempt.shortage = aircraft_.safety_margin_m - better.min_clearance;
      return Refused(
          attempt,
          RejectReason::kLoiterBlocked,
          Sentence("both circles are blocked; the better one clears %.1f m", better.min_clearance),
          better.obstacle_in_world);
    }
    const CircleCheck& circle = *direction == LoiterDirection::kLeft ? left : right;
    attempt.approach.loiter_direction = *direction;
    attempt.approach.loiter_center_in_world = LoiterCenter(attempt.approach, *direction);
    attempt.approach.unseen_ratio = circle.unseen_ratio;
    attempt.approach.min_clearance = std::min(attempt.approach.min_clearance, circle.min_clearance);
    const bool is_seen = circle.unseen_ratio == 0.0 && request_.wind_in_world.has_value();
    attempt.verdict = is_seen ? Verdict::kLandable : Verdict::kUnverified;
    return attempt;
  }

  const ElevationMap& map_;
  const HazardLayers& hazards_;
  const PlanRequest& request_;
  const Aircraft& aircraft_;
  const ApproachOptions& options_;
  ObstacleSurface surface_;
};

// Whether `a` is a better answer than `b`.
bool IsBetter(const Attempt& a, const Attempt& b) {
  if (a.verdict != b.verdict) return a.verdict < b.verdict;
  if (a.verdict == Verdict::kUnverified) return a.approach.unseen_ratio < b.approach.unseen_ratio;
  if (a.num_passed != b.num_passed) return a.num_passed > b.num_passed;
  return a.shortage < b.shortage;
}

// Of one candidate, over all headings.
Attempt BestHeading(const Planner& planner,
                    const Candidate& candidate,
                    const std::vector<double>& headings) {
  std::optional<Attempt> best;
  for (const double heading : headings) {
    Attempt attempt = planner.Try(candidate, heading);
    if (!best || IsBetter(attempt, *best)) best = std::move(attempt);
  }
  return *best;
}

Plan RejectedPlan(RejectReason reason,
                  std::string detail,
                  const std::optional<Candidate>& place,
                  const PlanRequest& request) {
  Plan plan;
  plan.verdict = Verdict::kRejected;
  plan.reject_reason = reason;
  plan.reject_detail = std::move(detail);
  plan.slope = plan.roughness = std::numeric_limits<double>::quiet_NaN();
  plan.touchdown_in_world.head<2>() = Centroid(request.footprint);
  if (place) {
    plan.touchdown_in_world = place->touchdown_in_world;
    plan.hazard_distance = place->hazard_distance;
  }
  return plan;
}

// Rules that need no path: nothing if the region passes them.
std::optional<Plan> RefusedAtOnce(const ElevationMap& map,
                                  const HazardLayers& hazards,
                                  const PlanRequest& request,
                                  const Aircraft& aircraft) {
  const std::optional<Candidate> place = LeastBadCell(map, hazards, request);
  if (!place) {
    return RejectedPlan(
        RejectReason::kNoTerrain, "no height is known inside the region", place, request);
  }
  if (request.area_m2 < aircraft.min_area_m2) {
    return RejectedPlan(
        RejectReason::kTooSmall,
        Sentence("%.0f m2, less than %.0f m2", request.area_m2, aircraft.min_area_m2),
        place,
        request);
  }
  if (request.num_observations < request.min_num_observations) {
    return RejectedPlan(
        RejectReason::kTooFewObservations,
        Sentence(
            "seen %d times, fewer than %d", request.num_observations, request.min_num_observations),
        place,
        request);
  }
  if (request.grade <= 0.0 || !HasGrass(hazards, request)) {
    return RejectedPlan(
        RejectReason::kNotGrass, "nothing in the region is known to be grass", place, request);
  }
  return std::nullopt;
}

Plan PlanFrom(const Attempt& attempt) {
  Plan plan;
  plan.verdict = attempt.verdict;
  plan.touchdown_in_world = attempt.candidate.touchdown_in_world;
  plan.hazard_distance = attempt.candidate.hazard_distance;
  if (attempt.rejection) {
    plan.reject_reason = attempt.rejection->reason;
    plan.reject_detail = attempt.rejection->detail;
  }
  if (attempt.approach.approach_distance > 0.0 && !attempt.approach.profile.distance.empty()) {
    plan.approach = attempt.approach;
  }
  return plan;
}

Plan BestPlan(const Planner& planner,
              const std::vector<Candidate>& candidates,
              const std::vector<double>& headings,
              const ApproachOptions& options) {
  std::optional<Attempt> best;
  std::vector<Rejection> rejections;
  for (const Candidate& candidate : candidates) {
    Attempt attempt = BestHeading(planner, candidate, headings);
    if (attempt.rejection && static_cast<int>(rejections.size()) < options.max_num_rejections) {
      rejections.push_back(*attempt.rejection);
    }
    if (!best || IsBetter(attempt, *best)) best = std::move(attempt);
    // Candidates come farthest from hazard first: the first free one wins.
    if (best->verdict == Verdict::kLandable) break;
  }
  Plan plan = PlanFrom(*best);
  plan.rejections = std::move(rejections);
  return plan;
}

void AddNumbers(Plan& plan,
                const HazardLayers& hazards,
                const PlanRequest& request,
                const Aircraft& aircraft,
                const ApproachOptions& options) {
  const double radius = std::max(aircraft.touchdown_uncertainty_m, hazards.grid.cell_size_m);
  const Ground ground = GroundAround(hazards, plan.touchdown_in_world.head<2>(), radius);
  plan.slope = ground.slope;
  plan.roughness = ground.roughness;
  plan.score_terms = ScoreTerms(plan, request, aircraft, options);
  plan.score = Score(plan.score_terms, plan.verdict);
}

void Require(bool holds, const char* field, double value, const char* constraint) {
  if (holds) return;
  throw std::invalid_argument(Sentence("approach.%s = %g: %s", field, value, constraint));
}

}  // namespace

void ApproachOptions::Check() const {
  Require(map_position_sd_m >= 0.0, "map_position_sd_m", map_position_sd_m, "must be >= 0");
  Require(unclear_height_allowance_m >= 0.0,
          "unclear_height_allowance_m",
          unclear_height_allowance_m,
          "must be >= 0");
  Require(max_num_candidates >= 1, "max_num_candidates", max_num_candidates, "must be >= 1");
  Require(candidate_spacing_m >= 0.0, "candidate_spacing_m", candidate_spacing_m, "must be >= 0");
  Require(heading_step_deg >= 1.0 && heading_step_deg <= 90.0,
          "heading_step_deg",
          heading_step_deg,
          "must be in [1, 90]");
  Require(calm_wind_mps >= 0.0 && calm_wind_mps <= 3.0,
          "calm_wind_mps",
          calm_wind_mps,
          "must be in [0, 3]");
  Require(path_step_m >= 0.05 && path_step_m <= 2.0,
          "path_step_m",
          path_step_m,
          "must be in [0.05, 2]");
  Require(max_num_rejections >= 0, "max_num_rejections", max_num_rejections, "must be >= 0");
  Require(score_weights.size() == kNumScoreTerms,
          "score_weights",
          static_cast<double>(score_weights.size()),
          "must have six entries");
  for (const double weight : score_weights) {
    Require(weight >= 0.0 && std::isfinite(weight), "score_weights", weight, "must be >= 0");
  }
}

Plan PlanApproach(const ElevationMap& map,
                  const HazardLayers& hazards,
                  const PlanRequest& request,
                  const Aircraft& aircraft,
                  const ApproachOptions& options) {
  std::optional<Plan> plan = RefusedAtOnce(map, hazards, request, aircraft);
  if (!plan) {
    const std::vector<Candidate> candidates =
        TouchdownCandidates(map, hazards, request, aircraft, options);
    if (candidates.empty()) {
      const std::optional<Candidate> place = LeastBadCell(map, hazards, request);
      plan = RejectedPlan(RejectReason::kNoSafeTouchdown,
                          Sentence("the best place is %.1f m from a hazard, %.1f m are needed",
                                   place->hazard_distance,
                                   NeededHazardDistance(map.grid, aircraft, options)),
                          place,
                          request);
    } else {
      const Planner planner(map, hazards, request, aircraft, options);
      plan = BestPlan(planner, candidates, HeadingsFor(request.wind_in_world, options), options);
    }
  }
  AddNumbers(*plan, hazards, request, aircraft, options);
  return *plan;
}

}  // namespace freelsd
