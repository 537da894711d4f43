// Private to cover/. Fuses the views into one probability of grass per cell.
#pragma once

#include "engine/cover/cover.h"

namespace freelsd {

// What the views say of each cell of the map. Without a limit of a view's probability but
// kMaxViewLogOdds.
struct ViewVotes {
  // Over the views that classified the cell; NaN where none did.
  cv::Mat1f mean_log_odds;
  cv::Mat1f spread;
  // Share of the views that see the cell; NaN where none does.
  cv::Mat1f vote_ratio;
  cv::Mat1f num_votes;
};
// No view is surer.
constexpr double kMaxViewLogOdds = 4.0;
ViewVotes CountVotes(const ElevationMap& map, const std::vector<GrassView>& grass_views);

// Posterior probability of each cell. With kPaperOr: 1 or 0. NaN if the elevation is unknown, or if
// too small a share of the views classified the cell.
cv::Mat1f FuseGrass(const ElevationMap& map,
                    const std::vector<GrassView>& grass_views,
                    const CoverOptions& options);

}  // namespace freelsd
