#include "engine/approach/attempt_verdict.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <tuple>

#include "engine/approach/attempt_risk.h"

namespace freelsd {
namespace {

// Progress of an attempt: ground roll, part of the final, circle, risk, or everything.
double Progress(const Attempt& attempt) {
  if (attempt.roll_hazard) return 0.0;
  if (attempt.final_path.obstacle || attempt.final_path.num_unseen_steps > 0) {
    return 1.0 + attempt.final_path.clear_ratio;
  }
  if (attempt.circle.obstacle) return 3.0;
  return attempt.is_risk_too_high ? 4.0 : 5.0;
}

}  // namespace

std::string Metres(double metres) {
  std::ostringstream text;
  text.setf(std::ios::fixed);
  text.precision(std::abs(metres) < 10.0 ? 1 : 0);
  text << metres << " m";
  return text.str();
}

std::string DescribeObstacle(const Obstacle& obstacle, double touchdown_height) {
  const double above_touchdown = obstacle.place_in_world.z() - touchdown_height;
  const std::string clearance = obstacle.clearance < 0.0
                                    ? Metres(-obstacle.clearance) + " above the path"
                                    : Metres(obstacle.clearance) + " below the path";
  return "by something " + Metres(above_touchdown) + " above the touchdown point, " + clearance +
         ", where " + Metres(obstacle.wanted) + " of clearance are needed";
}

std::optional<RejectReason> ReasonOf(const Attempt& attempt) {
  if (attempt.roll_hazard) return RejectReason::kNoSafeTouchdown;
  if (attempt.final_path.obstacle) return RejectReason::kApproachBlocked;
  if (attempt.final_path.num_unseen_steps > 0) return RejectReason::kApproachUnseen;
  if (attempt.circle.obstacle) return RejectReason::kLoiterBlocked;
  if (attempt.is_risk_too_high) return RejectReason::kRiskTooHigh;
  return std::nullopt;
}

Verdict VerdictOf(const Attempt& attempt, const WindCase& wind) {
  if (attempt.reason) return Verdict::kRejected;
  const bool is_wholly_seen = attempt.circle.num_unseen_steps == 0;
  return is_wholly_seen && wind.is_known ? Verdict::kLandable : Verdict::kUnverified;
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

std::string Percent(double ratio) {
  std::ostringstream text;
  text.setf(std::ios::fixed);
  text.precision(0);
  text << 100.0 * ratio << " %";
  return text.str();
}

std::string WhyRollFails(const RollHazard& hazard) {
  return "the ground roll meets " + std::string(hazard.is_unseen ? "unseen ground " : "a hazard ") +
         Metres(hazard.distance) + " beyond the touchdown point";
}

std::string WhyFinalFails(const Attempt& attempt, const Obstacle& obstacle) {
  return "the final is blocked " + Metres(obstacle.distance) + " before touchdown " +
         DescribeObstacle(obstacle, attempt.touchdown.place_in_world.z());
}

std::string WhyFinalIsUnseen(const Attempt& attempt) {
  return "the ground below the final was not seen from " +
         Metres(attempt.final_path.first_unseen_distance) + " before touchdown on";
}

std::string WhyCircleFails(const Attempt& attempt, const Obstacle& obstacle) {
  return "both loiter circles are blocked; the better one " +
         DescribeObstacle(obstacle, attempt.touchdown.place_in_world.z());
}

std::string WhyCircleIsUnseen(const Attempt& attempt) {
  return "along " + Percent(attempt.circle.UnseenRatio()) +
         " of the loiter circle some ground was not measured";
}

Rejection Explain(const Attempt& attempt, const AttemptContext& context) {
  Rejection rejection;
  rejection.touchdown_in_world = attempt.touchdown.place_in_world;
  // An attempt without a reason was unverified, and a fully seen attempt was preferred.
  rejection.reason = attempt.reason.value_or(RejectReason::kApproachUnseen);
  if (attempt.roll_hazard) {
    const Eigen::Vector2d& place = attempt.roll_hazard->place_in_world;
    rejection.detail = WhyRollFails(*attempt.roll_hazard);
    rejection.obstacle_in_world = {place.x(), place.y(), attempt.touchdown.place_in_world.z()};
  } else if (const auto& obstacle = attempt.final_path.obstacle) {
    rejection.detail = WhyFinalFails(attempt, *obstacle);
    rejection.obstacle_in_world = obstacle->place_in_world;
  } else if (attempt.final_path.num_unseen_steps > 0) {
    rejection.detail = WhyFinalIsUnseen(attempt);
  } else if (const auto& circled = attempt.circle.obstacle) {
    rejection.detail = WhyCircleFails(attempt, *circled);
    rejection.obstacle_in_world = circled->place_in_world;
  } else if (attempt.is_risk_too_high) {
    rejection.detail = DescribeRisk(RiskOf(attempt, context), context.risk.max_failure_probability);
  } else {
    rejection.detail = WhyCircleIsUnseen(attempt);
  }
  if (!context.wind.is_known && attempt.reason) {
    rejection.detail +=
        " (no wind known, best of " + std::to_string(context.wind.headings.size()) + " headings)";
  }
  return rejection;
}

}  // namespace freelsd
