#include "engine/approach/attempt.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <tuple>

namespace freelsd {
namespace {

// "41 m" from 10 m on, "6.3 m" below.
std::string Metres(double metres) {
  std::ostringstream text;
  text.setf(std::ios::fixed);
  text.precision(std::abs(metres) < 10.0 ? 1 : 0);
  text << metres << " m";
  return text.str();
}

std::string Percent(double ratio) {
  std::ostringstream text;
  text.setf(std::ios::fixed);
  text.precision(0);
  text << 100.0 * ratio << " %";
  return text.str();
}

Approach ApproachOf(const Attempt& attempt,
                    const AttemptContext& context,
                    const WindScenario& scenario) {
  return MakeApproach(attempt.touchdown.place_in_world,
                      attempt.heading,
                      scenario,
                      attempt.direction,
                      context.aircraft.approach_height_m);
}

const std::vector<WindScenario>& ScenariosOf(const Attempt& attempt,
                                             const AttemptContext& context) {
  return context.wind.headings[attempt.heading_index].scenarios;
}

CellsBelow Below(const Touchdown& touchdown, const AttemptContext& context) {
  const ClearanceSurface& surface = context.surface;
  return {surface,
          touchdown.row - surface.first_row,
          touchdown.col - surface.first_col,
          touchdown.place_in_world.z()};
}

bool IsRollFreeAtAGlance(const Attempt& attempt, const AttemptContext& context) {
  return Below(attempt.touchdown, context)
      .IsRollFree(context.cells[attempt.heading_index].ground_roll);
}

PathCheck FinalOf(const Attempt& attempt,
                  size_t scenario,
                  const AttemptContext& context,
                  Depth depth) {
  if (depth == Depth::kUntilFailure) {
    const PathCells& cells = context.cells[attempt.heading_index].scenarios[scenario];
    const auto glance = Below(attempt.touchdown, context).GlanceAlongFinal(cells);
    if (glance) return *glance;
  }
  const Approach approach = ApproachOf(attempt, context, ScenariosOf(attempt, context)[scenario]);
  return CheckFinal(approach, context.surface, context.aircraft, context.options, depth);
}

PathCheck FinalOf(const Attempt& attempt, const AttemptContext& context, Depth depth) {
  PathCheck check;
  for (size_t scenario = 0; scenario < ScenariosOf(attempt, context).size(); ++scenario) {
    check = Worse(check, FinalOf(attempt, scenario, context, depth));
    if (depth == Depth::kUntilFailure && check.clear_ratio < 1.0) break;
  }
  return check;
}

PathCheck CircleOf(const Attempt& attempt,
                   size_t scenario,
                   const AttemptContext& context,
                   Depth depth) {
  if (depth == Depth::kUntilFailure) {
    const PathCells& cells = context.cells[attempt.heading_index].scenarios[scenario];
    return Below(attempt.touchdown, context)
        .CheckCircle(cells, attempt.direction, context.aircraft.approach_height_m);
  }
  const Approach approach = ApproachOf(attempt, context, ScenariosOf(attempt, context)[scenario]);
  return CheckCircle(approach, context.surface, context.aircraft);
}

PathCheck CircleOf(const Attempt& attempt, const AttemptContext& context, Depth depth) {
  PathCheck check;
  for (size_t scenario = 0; scenario < ScenariosOf(attempt, context).size(); ++scenario) {
    check = Worse(check, CircleOf(attempt, scenario, context, depth));
    if (depth == Depth::kUntilFailure && check.obstacle) break;
  }
  return check;
}

// Clear circles first, then less unseen, then more clearance; left if all are equal.
bool IsBetterCircle(const PathCheck& a, const PathCheck& b) {
  const auto key = [](const PathCheck& circle) {
    return std::tuple(circle.obstacle.has_value(), circle.UnseenRatio(), -circle.min_clearance);
  };
  return key(a) < key(b);
}

Attempt WithCircle(const Attempt& attempt, const AttemptContext& context, Depth depth) {
  Attempt left = attempt, right = attempt;
  left.direction = LoiterDirection::kLeft;
  right.direction = LoiterDirection::kRight;
  left.circle = CircleOf(left, context, depth);
  right.circle = CircleOf(right, context, depth);
  return IsBetterCircle(right.circle, left.circle) ? right : left;
}

std::optional<RejectReason> ReasonOf(const Attempt& attempt) {
  if (attempt.roll_hazard) return RejectReason::kNoSafeTouchdown;
  if (attempt.final_path.obstacle) return RejectReason::kApproachBlocked;
  if (attempt.final_path.num_unseen_steps > 0) return RejectReason::kApproachUnseen;
  if (attempt.circle.obstacle) return RejectReason::kLoiterBlocked;
  return std::nullopt;
}

Verdict VerdictOf(const Attempt& attempt, const WindCase& wind) {
  if (attempt.reason) return Verdict::kRejected;
  const bool is_wholly_seen = attempt.circle.num_unseen_steps == 0;
  return is_wholly_seen && wind.is_known ? Verdict::kLandable : Verdict::kUnverified;
}

// Progress of an attempt: ground roll, part of the final, circle, or everything.
double Progress(const Attempt& attempt) {
  if (attempt.roll_hazard) return 0.0;
  if (attempt.final_path.obstacle || attempt.final_path.num_unseen_steps > 0) {
    return 1.0 + attempt.final_path.clear_ratio;
  }
  return attempt.circle.obstacle ? 3.0 : 4.0;
}

std::string DescribeObstacle(const Attempt& attempt, const Obstacle& obstacle) {
  const double above_touchdown = obstacle.place_in_world.z() - attempt.touchdown.place_in_world.z();
  const std::string clearance = obstacle.clearance < 0.0
                                    ? Metres(-obstacle.clearance) + " above the path"
                                    : Metres(obstacle.clearance) + " below the path";
  return "by something " + Metres(above_touchdown) + " above the touchdown point, " + clearance +
         ", where " + Metres(obstacle.wanted) + " of clearance are needed";
}

std::string DescribeRoll(const RollHazard& hazard) {
  return "the ground roll meets " + std::string(hazard.is_unseen ? "unseen ground " : "a hazard ") +
         Metres(hazard.distance) + " behind the touchdown point";
}

}  // namespace

Attempt Try(const Touchdown& touchdown,
            size_t heading_index,
            const AttemptContext& context,
            Depth depth) {
  const bool is_thorough = depth == Depth::kEverything;
  Attempt attempt;
  attempt.touchdown = touchdown;
  attempt.heading_index = heading_index;
  attempt.heading = context.wind.headings[heading_index].heading;
  if (is_thorough || !IsRollFreeAtAGlance(attempt, context)) {
    attempt.roll_hazard = CheckGroundRoll(
        touchdown.place_in_world, attempt.heading, context.surface, context.aircraft);
  }
  if (!ReasonOf(attempt) || is_thorough) attempt.final_path = FinalOf(attempt, context, depth);
  if (!ReasonOf(attempt) || is_thorough) attempt = WithCircle(attempt, context, depth);
  attempt.reason = ReasonOf(attempt);
  attempt.verdict = VerdictOf(attempt, context.wind);
  return attempt;
}

bool IsBetter(const Attempt& a, const Attempt& b) {
  const auto key = [](const Attempt& attempt) {
    return std::tuple(attempt.verdict,  // in order of declaration: landable first
                      -Progress(attempt),
                      attempt.circle.UnseenRatio(),
                      -std::min(attempt.final_path.min_clearance, attempt.circle.min_clearance));
  };
  return key(a) < key(b);
}

Attempt BestHeading(const Touchdown& touchdown, const AttemptContext& context) {
  Attempt best = Try(touchdown, 0, context, Depth::kUntilFailure);
  for (size_t i = 1; i < context.wind.headings.size(); ++i) {
    const Attempt attempt = Try(touchdown, i, context, Depth::kUntilFailure);
    if (IsBetter(attempt, best)) best = attempt;
  }
  return best;
}

Rejection Explain(const Attempt& attempt, const AttemptContext& context) {
  Rejection rejection;
  rejection.touchdown_in_world = attempt.touchdown.place_in_world;
  // An attempt without a reason lost against one that is fully seen.
  rejection.reason = attempt.reason.value_or(RejectReason::kApproachUnseen);
  if (attempt.roll_hazard) {
    const Eigen::Vector2d& place = attempt.roll_hazard->place_in_world;
    rejection.detail = DescribeRoll(*attempt.roll_hazard);
    rejection.obstacle_in_world = {place.x(), place.y(), attempt.touchdown.place_in_world.z()};
  } else if (const auto& obstacle = attempt.final_path.obstacle) {
    rejection.detail = "the final is blocked " + Metres(obstacle->distance) + " before touchdown " +
                       DescribeObstacle(attempt, *obstacle);
    rejection.obstacle_in_world = obstacle->place_in_world;
  } else if (attempt.final_path.num_unseen_steps > 0) {
    rejection.detail = "the ground below the final was not seen from " +
                       Metres(attempt.final_path.first_unseen_distance) + " before touchdown on";
  } else if (const auto& circled = attempt.circle.obstacle) {
    rejection.detail =
        "both loiter circles are blocked; the better one " + DescribeObstacle(attempt, *circled);
    rejection.obstacle_in_world = circled->place_in_world;
  } else {
    rejection.detail = Percent(attempt.circle.UnseenRatio()) + " of the loiter circle was not seen";
  }
  if (!context.wind.is_known && attempt.reason) {
    rejection.detail +=
        " (no wind known, best of " + std::to_string(context.wind.headings.size()) + " headings)";
  }
  return rejection;
}

Approach DescribeApproach(const Attempt& attempt, const AttemptContext& context) {
  Approach approach = ApproachOf(attempt, context, ScenariosOf(attempt, context).front());
  const double clearance = std::min(attempt.final_path.min_clearance, attempt.circle.min_clearance);
  approach.min_clearance =
      std::isfinite(clearance) ? clearance : std::numeric_limits<double>::quiet_NaN();
  approach.unseen_ratio = attempt.circle.UnseenRatio();
  return approach;
}

}  // namespace freelsd
