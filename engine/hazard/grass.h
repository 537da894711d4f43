// Private to hazard/. What all views together say of a cell being grass.
#pragma once

#include "engine/hazard/hazard.h"

namespace freelsd {

// Posterior probability (or the paper's OR as 0 and 1); NaN where there is no elevation to project
// or too few views classified the cell.
cv::Mat1f FuseGrass(const ElevationMap& map,
                    const std::vector<GrassView>& grass_views,
                    const HazardOptions& options);

}  // namespace freelsd
