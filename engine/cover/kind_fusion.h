// Private to cover/. Fuses what the views say of each cell.
#pragma once

#include "engine/cover/cover.h"

namespace freelsd {

// One value per cell of the map.
struct FusedKinds {
  // Posterior probability of grass. With kPaperOr: 1 or 0. NaN if the elevation is unknown, or if
  // too small a share of the views told the cell.
  cv::Mat1f grass;
  // Likeliest of the other kinds (OtherKind): its probability is the mean over the views that told
  // the cell, where a view counts only for the kind that it found likeliest. 0 where no view did.
  cv::Mat1b other;
};

FusedKinds FuseKinds(const ElevationMap& map,
                     const std::vector<KindView>& kind_views,
                     const CoverOptions& options);

}  // namespace freelsd
