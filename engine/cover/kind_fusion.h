// Private to cover/. Fuses what the views say of each cell.
#pragma once

#include <utility>

#include "engine/cover/cover.h"

namespace freelsd {

// One value per cell of the map:
// - Posterior probability of grass. With kPaperOr: 1 or 0. NaN if the elevation is unknown, or if
//   too small a share of the views told the cell.
// - Likeliest of the other kinds (LikelyKind): its probability is the mean over the views that told
//   the cell, where a view counts only for the kind that it found likeliest. 0 where no view did.
std::pair<cv::Mat1f, cv::Mat1b> FuseKinds(const ElevationMap& map,
                                          const std::vector<KindView>& kind_views,
                                          const CoverOptions& options,
                                          const Orthophoto& photo);

}  // namespace freelsd
