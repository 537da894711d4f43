#include "engine/approach/path_rules.h"

#include <algorithm>
#include <cctype>

#include "engine/approach/attempt_verdict.h"

namespace freelsd {
namespace {

PlaceRule RollRule(const Attempt& attempt,
                   const AttemptContext& context,
                   const LandingStrip& strip) {
  const double needed = context.aircraft.ground_roll_m;
  PlaceRule rule{.name = "ground_roll", .passed = !attempt.roll_hazard, .unit = "m"};
  rule.limit = needed;
  if (attempt.roll_hazard) {
    rule.value = attempt.roll_hazard->distance;
    rule.sentence =
        Sentence(WhyRollFails(*attempt.roll_hazard) + "; " + Metres(needed) + " must be free");
  } else {
    // The strip is measured in steps. It may therefore end a fraction of a cell before the ground
    // roll that was checked.
    rule.value = std::max(strip.ahead, needed);
    rule.sentence = "The ground roll is free for " + Metres(*rule.value) +
                    " beyond the touchdown point; " + Metres(needed) + " must be free.";
  }
  return rule;
}

std::string PassedOver(const std::string& path, const std::optional<PathObstacle>& obstacle) {
  if (!obstacle) return path + " passes over no obstacle.";
  return path + " passes " + Metres(obstacle->clearance) + " above the tightest obstacle, " +
         Metres(obstacle->distance) + " from touchdown; " + Metres(obstacle->wanted) +
         " are needed.";
}

// The check's own obstacle if it fails, else the tightest one.
PlaceRule ClearanceRule(const std::string& name,
                        const std::optional<Obstacle>& blocking,
                        const std::optional<PathObstacle>& tightest) {
  PlaceRule rule{.name = name, .passed = !blocking, .unit = "m"};
  if (blocking) {
    rule.value = blocking->clearance;
    rule.limit = blocking->wanted;
  } else if (tightest) {
    rule.value = tightest->clearance;
    rule.limit = tightest->wanted;
  }
  return rule;
}

PlaceRule FinalRule(const Attempt& attempt, const std::optional<PathObstacle>& tightest) {
  const std::optional<Obstacle>& blocking = attempt.final_path.obstacle;
  PlaceRule rule = ClearanceRule("final", blocking, tightest);
  rule.sentence =
      blocking ? Sentence(WhyFinalFails(attempt, *blocking)) : PassedOver("The final", tightest);
  return rule;
}

PlaceRule SeenFinalRule(const Attempt& attempt) {
  PlaceRule rule{.name = "final_seen",
                 .passed = attempt.final_path.num_unseen_steps == 0,
                 .value = attempt.final_path.UnseenRatio(),
                 .limit = 0.0,
                 .unit = "ratio"};
  rule.sentence =
      rule.passed ? "The ground below the final was seen." : Sentence(WhyFinalIsUnseen(attempt));
  return rule;
}

PlaceRule CircleRule(const Attempt& attempt, const std::optional<PathObstacle>& tightest) {
  const std::optional<Obstacle>& blocking = attempt.circle.obstacle;
  PlaceRule rule = ClearanceRule("circle", blocking, tightest);
  rule.sentence = blocking ? Sentence(WhyCircleFails(attempt, *blocking))
                           : PassedOver("The loiter circle", tightest);
  return rule;
}

PlaceRule SeenCircleRule(const Attempt& attempt) {
  PlaceRule rule{.name = "circle_seen",
                 .passed = attempt.circle.num_unseen_steps == 0,
                 .value = attempt.circle.UnseenRatio(),
                 .limit = 0.0,
                 .unit = "ratio"};
  rule.sentence = rule.passed ? "The ground below the loiter circle was seen."
                              : Sentence(WhyCircleIsUnseen(attempt));
  return rule;
}

PlaceRule KnownWindRule(const WindCase& wind) {
  return {.name = "wind_known",
          .passed = wind.is_known,
          .sentence = wind.is_known ? "The wind is known."
                                    : "The wind is unknown: the best of " +
                                          std::to_string(wind.headings.size()) +
                                          " headings is at most unverified."};
}

}  // namespace

std::vector<PlaceRule> PathRules(const Attempt& attempt,
                                 const AttemptContext& context,
                                 const LandingStrip& strip,
                                 const PathObstacles& obstacles) {
  return {RollRule(attempt, context, strip),
          FinalRule(attempt, obstacles.on_final),
          SeenFinalRule(attempt),
          CircleRule(attempt, obstacles.on_circle),
          SeenCircleRule(attempt),
          KnownWindRule(context.wind)};
}

std::string Sentence(std::string text) {
  if (text.empty()) return text;
  text.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(text.front())));
  if (text.back() != '.') text += '.';
  return text;
}

}  // namespace freelsd
