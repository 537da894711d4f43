// Private to cover/. Fuses the views into one probability of grass per cell.
#pragma once

#include "engine/cover/cover.h"

namespace freelsd {

// Mean log-odds of grass over the views that classified the cell, each within kMaxViewLogOdds; NaN
// where none did.
constexpr double kMaxViewLogOdds = 4.0;
cv::Mat1f MeanLogOdds(const ElevationMap& map, const std::vector<GrassView>& grass_views);

// Posterior probability of each cell. With kPaperOr: 1 or 0. NaN if the elevation is unknown, or if
// too small a share of the views classified the cell.
cv::Mat1f FuseGrass(const ElevationMap& map,
                    const std::vector<GrassView>& grass_views,
                    const CoverOptions& options);

}  // namespace freelsd
