#include "engine/approach/search.h"

#include <utility>

#include "engine/approach/attempt_risk.h"
#include "engine/approach/attempt_verdict.h"

namespace freelsd {
namespace {

bool IsTaken(const Attempt& attempt, const Attempt& best) {
  if (attempt.verdict == Verdict::kRejected) return IsBetter(attempt, best);
  return attempt.verdict < best.verdict;
}

bool IsSamePlace(const Touchdown& a, const Touchdown& b) {
  return a.row == b.row && a.col == b.col;
}

// The first good touchdown of the reserve; else the least bad one, including the best so far.
Attempt BestOfReserve(const std::vector<Touchdown>& reserve,
                      Attempt best,
                      const AttemptContext& context) {
  for (const Touchdown& candidate : reserve) {
    if (best.verdict != Verdict::kRejected) break;
    Attempt attempt = BestHeading(candidate, context);
    if (IsTaken(attempt, best)) attempt = WithRisk(std::move(attempt), context);
    if (IsTaken(attempt, best)) best = std::move(attempt);
  }
  return best;
}

}  // namespace

SearchResult SearchTouchdown(const TouchdownCandidates& candidates, const AttemptContext& context) {
  std::optional<Attempt> best;
  std::vector<Attempt> tried;
  for (const Touchdown& candidate : candidates.first) {
    Attempt attempt = BestHeading(candidate, context);
    if (!best || IsTaken(attempt, *best)) attempt = WithRisk(std::move(attempt), context);
    if (!best || IsTaken(attempt, *best)) best = attempt;
    if (attempt.verdict == Verdict::kLandable) break;
    if (attempt.verdict == Verdict::kUnverified && !context.wind.is_known) break;
    tried.push_back(std::move(attempt));
  }
  SearchResult result;
  result.best = BestOfReserve(candidates.reserve, *best, context);
  // Attempts after the chosen one are kept only if none was good.
  for (Attempt& attempt : tried) {
    const bool is_chosen = IsSamePlace(attempt.touchdown, result.best.touchdown);
    if (is_chosen && attempt.verdict != Verdict::kRejected) break;
    result.passed_over.push_back(std::move(attempt));
  }
  return result;
}

}  // namespace freelsd
