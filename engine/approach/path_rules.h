// Private to approach/: the rules of a path, one by one.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "engine/approach/attempt.h"

namespace freelsd {

struct PathObstacles {
  std::optional<PathObstacle> on_final, on_circle;
};

// The rules ground_roll to wind_known of PlaceRule::name. They agree with ReasonOf and VerdictOf.
// The attempt must be thorough (Depth::kEverything).
std::vector<PlaceRule> PathRules(const Attempt& attempt,
                                 const AttemptContext& context,
                                 const LandingStrip& strip,
                                 const PathObstacles& obstacles);

// The text as a sentence: upper case at its start, a full stop at its end.
std::string Sentence(std::string text);

}  // namespace freelsd
