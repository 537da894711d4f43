// Private to cover/. Fuses the views into one probability of grass per cell.
#pragma once

#include "engine/cover/cover.h"

namespace freelsd {

// Posterior probability of each cell. With kPaperOr: 1 or 0. NaN if the elevation is unknown, or if
// too small a share of the views classified the cell.
cv::Mat1f FuseGrass(const ElevationMap& map,
                    const std::vector<GrassView>& grass_views,
                    const CoverOptions& options);

}  // namespace freelsd
