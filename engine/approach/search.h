// Private to approach/: the search over the touchdowns of a region.
#pragma once

#include <vector>

#include "engine/approach/attempt.h"

namespace freelsd {

struct SearchResult {
  Attempt best;
  // Attempts tried before it and not chosen; all attempts if none was good.
  std::vector<Attempt> passed_over;
};

// Sec. III-H: tries touchdowns from the safest on. Returns the first landable one, else the first
// unverified one, else the least bad one. Tries the reserve if no first candidate is good. Needs at
// least one candidate.
SearchResult SearchTouchdown(const TouchdownCandidates& candidates, const AttemptContext& context);

}  // namespace freelsd
