#include "engine/approach/attempt.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "engine/approach/attempt_verdict.h"
#include "engine/approach/landing_strip.h"
#include "engine/approach/tightest_obstacle.h"

namespace freelsd {
namespace {

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

Attempt BestHeading(const Touchdown& touchdown, const AttemptContext& context) {
  Attempt best = Try(touchdown, 0, context, Depth::kUntilFailure);
  for (size_t i = 1; i < context.wind.headings.size(); ++i) {
    const Attempt attempt = Try(touchdown, i, context, Depth::kUntilFailure);
    if (IsBetter(attempt, best)) best = attempt;
  }
  return best;
}

Approach DescribeApproach(const Attempt& attempt, const AttemptContext& context) {
  Approach approach = ApproachOf(attempt, context, ScenariosOf(attempt, context).front());
  const double clearance = std::min(attempt.final_path.min_clearance, attempt.circle.min_clearance);
  approach.min_clearance =
      std::isfinite(clearance) ? clearance : std::numeric_limits<double>::quiet_NaN();
  approach.unseen_ratio = attempt.circle.UnseenRatio();
  approach.ground_roll_in_world =
      GroundRollCorners(approach.touchdown_in_world, approach.heading, context.aircraft);
  return approach;
}

std::vector<Approach> ApproachesOf(const Attempt& attempt, const AttemptContext& context) {
  std::vector<Approach> approaches;
  for (const WindScenario& scenario : ScenariosOf(attempt, context)) {
    approaches.push_back(ApproachOf(attempt, context, scenario));
  }
  return approaches;
}

std::optional<PathObstacle> TightestOf(const Attempt& attempt,
                                       const AttemptContext& context,
                                       PathPart part) {
  std::optional<PathObstacle> tightest;
  for (const Approach& flown : ApproachesOf(attempt, context)) {
    tightest =
        Tighter(tightest,
                part == PathPart::kCircle
                    ? TightestOnCircle(flown, context.surface, context.aircraft)
                    : TightestOnFinal(flown, context.surface, context.aircraft, context.options));
  }
  return tightest;
}

}  // namespace freelsd
