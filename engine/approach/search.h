// Private to approach/: the search over the touchdowns of a region.
#pragma once

#include <vector>

#include "engine/approach/attempt.h"

namespace freelsd {

struct SearchResult {
  Attempt best;
  // Attempts that were tried before the best one, in that order. Only attempts at candidates of
  // TouchdownCandidates::first are included. All of these are included if the best attempt is
  // rejected, or if it is at a reserve candidate.
  std::vector<Attempt> passed_over;
};

// Sec. III-H. Needs at least one first candidate. Tries the first candidates, the safest first:
// - The first landable attempt is the best.
// - If none is landable, the first unverified attempt is the best.
// - If all are rejected, the reserve is tried. Its first landable or unverified attempt is the
//   best.
// An attempt that would be taken is rejected instead if its risk is too high.
// - If the reserve is rejected too, the least bad attempt is the best.
SearchResult SearchTouchdown(const TouchdownCandidates& candidates, const AttemptContext& context);

}  // namespace freelsd
