// Private to approach/: the probability that the landing of an attempt fails.
#pragma once

#include <string>

#include "engine/approach/attempt.h"

namespace freelsd {

// What the risk of an attempt depends on, besides its path. The aircraft of the assessor has no
// margins for the map's position: the risk averages over that position instead.
struct RiskBasis {
  RiskAssessor assessor;
  double wind_spread_mps = 0.0;
  double position_sd_m = 0.0;
  double max_failure_probability = 1.0;
};

LandingRisk RiskOf(const Attempt& attempt, const AttemptContext& context);

// Rejects the attempt if its risk is above the limit. Any other attempt is unchanged.
Attempt WithRisk(Attempt attempt, const AttemptContext& context);

// The attempt, checked thoroughly. Keeps the excessive risk that the search found.
Attempt Thorough(const Attempt& attempt, const AttemptContext& context);

// "a landing here fails with a probability of 0.12, 0.05 is allowed; the largest part is the
// ground, 0.10".
std::string DescribeRisk(const LandingRisk& risk, double max_failure_probability);

PlaceRule RiskRule(const LandingRisk& risk, double max_failure_probability);

}  // namespace freelsd
