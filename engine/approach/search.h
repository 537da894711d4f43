// Private to approach/: the search over the touchdowns of a region.
#pragma once

#include <vector>

#include "engine/approach/attempt.h"

namespace freelsd {

struct SearchResult {
  Attempt best;
  // Tried before it, and not taken; all of them where none was good.
  std::vector<Attempt> passed_over;
};

// Sec. III-H: from the safest touchdown on, the first free one wins; else the first unverified one;
// else the least bad one. The reserve is looked at where none of the first ones is good. At least
// one candidate.
SearchResult SearchTouchdown(const TouchdownCandidates& candidates, const AttemptContext& context);

}  // namespace freelsd
