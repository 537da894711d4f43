#include "engine/cover/grass.h"
#include "engine/cover/kind/cue_groups.h"

namespace freelsd {
namespace {

// Side of the square around a cell.
constexpr double kNearM = 5.0;

}  // namespace

cv::Mat1f VisitViewCues(const CueInput& input, const CueVisitor& visit) {
  cv::Mat1f log_odds = MeanLogOdds(input.map, input.grass_views);
  visit(Cue::kViewLogOdds, log_odds);
  visit(Cue::kViewLogOddsNear, KnownMean(log_odds, kNearM / input.map.grid.cell_size_m));
  return log_odds;
}

}  // namespace freelsd
