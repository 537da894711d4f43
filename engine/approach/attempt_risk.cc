#include "engine/approach/attempt_risk.h"

#include <algorithm>
#include <sstream>
#include <utility>

#include "engine/approach/attempt_verdict.h"
#include "engine/approach/path_rules.h"

namespace freelsd {
namespace {

PlannedLanding LandingOf(const Attempt& attempt, const AttemptContext& context) {
  const Approach approach = DescribeApproach(attempt, context);
  return {.touchdown_in_world = approach.touchdown_in_world,
          .heading = approach.heading,
          .approach_distance = approach.approach_distance,
          .approach_height = approach.approach_height,
          .ground_speed = approach.ground_speed.value_or(context.aircraft.landing_airspeed_mps),
          .wind_spread_mps = context.risk.wind_spread_mps,
          .position_sd_m = context.risk.position_sd_m,
          .loiter_center_in_world = approach.loiter_center_in_world.head<2>(),
          .loiter_radius = approach.loiter_radius};
}

std::string Shown(double probability) {
  std::ostringstream text;
  text.precision(2);
  text << probability;
  return text.str();
}

}  // namespace

LandingRisk RiskOf(const Attempt& attempt, const AttemptContext& context) {
  return context.risk.assessor.Assess(LandingOf(attempt, context));
}

Attempt WithRisk(Attempt attempt, const AttemptContext& context) {
  if (attempt.verdict == Verdict::kRejected) return attempt;
  const double risk = context.risk.assessor.FailureProbability(LandingOf(attempt, context));
  if (risk <= context.risk.max_failure_probability) return attempt;
  attempt.is_risk_too_high = true;
  attempt.reason = ReasonOf(attempt);
  attempt.verdict = VerdictOf(attempt, context.wind);
  return attempt;
}

Attempt Thorough(const Attempt& attempt, const AttemptContext& context) {
  Attempt thorough = Try(attempt.touchdown, attempt.heading_index, context, Depth::kEverything);
  thorough.is_risk_too_high = attempt.is_risk_too_high;
  thorough.reason = ReasonOf(thorough);
  thorough.verdict = VerdictOf(thorough, context.wind);
  return thorough;
}

std::string DescribeRisk(const LandingRisk& risk, double max_failure_probability) {
  const std::pair<double, const char*> parts[] = {{risk.parts.ground, "the ground"},
                                                  {risk.parts.final_path, "the final"},
                                                  {risk.parts.circle, "the circle"}};
  const auto& [value, name] =
      *std::max_element(std::begin(parts), std::end(parts), [](const auto& a, const auto& b) {
        return a.first < b.first;
      });
  return "a landing here fails with a probability of " + Shown(risk.failure_probability) + ", " +
         Shown(max_failure_probability) + " is allowed; the largest part is " + name + ", " +
         Shown(value);
}

PlaceRule RiskRule(const LandingRisk& risk, double max_failure_probability) {
  return {.name = "risk",
          .passed = risk.failure_probability <= max_failure_probability,
          .value = risk.failure_probability,
          .limit = max_failure_probability,
          .unit = "ratio",
          .sentence = Sentence(DescribeRisk(risk, max_failure_probability))};
}

}  // namespace freelsd
