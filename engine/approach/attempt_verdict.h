// Private to approach/: what a tried path means: its verdict, the rule that rejects it, the order
// of attempts, and the sentence for people.
#pragma once

#include <optional>
#include <string>

#include "engine/approach/attempt.h"

namespace freelsd {

// The first rule that rejects the attempt, if any: ground roll, final blocked, final over unseen
// ground, circle blocked.
std::optional<RejectReason> ReasonOf(const Attempt& attempt);

// From attempt.reason, the unseen part of the circle, and whether the wind is known.
Verdict VerdictOf(const Attempt& attempt, const WindCase& wind);

// By verdict, then clearance and unseen share; rejected attempts by how far they got.
bool IsBetter(const Attempt& a, const Attempt& b);

// "41 m" from 10 m on, "6.3 m" below.
std::string Metres(double metres);
// "by something 4.0 m above the touchdown point, …".
std::string DescribeObstacle(const Obstacle& obstacle, double touchdown_height);
std::string Percent(double ratio);

// One sentence part per rule that the attempt breaks.
std::string WhyRollFails(const RollHazard& hazard);
std::string WhyFinalFails(const Attempt& attempt, const Obstacle& obstacle);
std::string WhyFinalIsUnseen(const Attempt& attempt);
std::string WhyCircleFails(const Attempt& attempt, const Obstacle& obstacle);
std::string WhyCircleIsUnseen(const Attempt& attempt);

// Reason of the rejection, in a sentence with numbers.
Rejection Explain(const Attempt& attempt, const AttemptContext& context);

}  // namespace freelsd
