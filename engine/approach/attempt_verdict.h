// Private to approach/: judges an attempt. Gives its verdict, the rule that rejects it, and a
// sentence for people, and compares two attempts.
#pragma once

#include <optional>
#include <string>

#include "engine/approach/attempt.h"

namespace freelsd {

// The first rule that rejects the attempt, if any. The rules in order: ground roll not free, final
// blocked, final over unseen ground, circle blocked, risk too high.
std::optional<RejectReason> ReasonOf(const Attempt& attempt);

// Rejected if attempt.reason is set. Landable if the whole circle is seen and the wind is known.
// Otherwise unverified.
Verdict VerdictOf(const Attempt& attempt, const WindCase& wind);

// Whether `a` is better than `b`. The first of these values that differs decides:
// 1. verdict: landable, then unverified, then rejected;
// 2. first failure, worst to best: ground roll, final (by its clear share), circle, risk, none;
// 3. unseen share of the circle, less is better;
// 4. least clearance of final and circle, more is better.
bool IsBetter(const Attempt& a, const Attempt& b);

// "41 m" if at least 10 m, else with one decimal: "6.3 m".
std::string Metres(double metres);
// "by something 4.0 m above the touchdown point, …".
std::string DescribeObstacle(const Obstacle& obstacle, double touchdown_height);
std::string Percent(double ratio);

// Each returns a part of a sentence: why the attempt breaks this one rule.
std::string WhyRollFails(const RollHazard& hazard);
std::string WhyFinalFails(const Attempt& attempt, const Obstacle& obstacle);
std::string WhyFinalIsUnseen(const Attempt& attempt);
std::string WhyCircleFails(const Attempt& attempt, const Obstacle& obstacle);
std::string WhyCircleIsUnseen(const Attempt& attempt);

// Reason of the rejection, in a sentence with numbers.
Rejection Explain(const Attempt& attempt, const AttemptContext& context);

}  // namespace freelsd
