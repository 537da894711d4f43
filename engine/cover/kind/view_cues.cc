#include <cmath>
#include <limits>

#include "engine/cover/grass.h"
#include "engine/cover/kind/cue_groups.h"

namespace freelsd {
namespace {

// Sides of the squares around a cell.
constexpr double kNearM = 5.0;
constexpr double kFarM = 17.0;

}  // namespace

cv::Mat1f VisitViewCues(const CueInput& input, const CueVisitor& visit) {
  const ViewVotes votes = CountVotes(input.map, input.grass_views);
  const double cell = input.map.grid.cell_size_m;
  visit(Cue::kViewLogOdds, votes.mean_log_odds);
  visit(Cue::kViewLogOddsNear, KnownMean(votes.mean_log_odds, kNearM / cell));
  visit(Cue::kViewLogOddsFar, KnownMean(votes.mean_log_odds, kFarM / cell));
  visit(Cue::kViewSpread, votes.spread);
  visit(Cue::kVoteRatio, votes.vote_ratio);
  visit(Cue::kVoteRatioNear, KnownMean(votes.vote_ratio, kNearM / cell));
  visit(Cue::kNumViews, votes.num_votes);
  return votes.mean_log_odds;
}

}  // namespace freelsd
