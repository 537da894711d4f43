// Private to hazard/: green ground that stands above what surrounds it, as a crop does.
#pragma once

#include <vector>

#include "engine/hazard/hazard.h"

namespace freelsd {

// One connected piece of ground that looks like grass, against what lies a few metres outside.
struct EdgeLevel {
  // Cells outside that were seen: lower than the piece goes on to there, as high, higher.
  int num_below = 0;
  int num_level = 0;
  int num_above = 0;

  // The piece stands up, or too little of its surroundings tells: hedges and woods around it hide
  // what it stands on. A piece whose surroundings were hardly seen at all is not judged.
  bool IsSuspect(const HazardOptions& options) const;
};

// 255 where grass (posterior of at least options.min_grass_posterior) is suspect to be a standing
// crop. `elevation` as trusted: NaN where unseen.
cv::Mat1b FindStandingGrowth(const cv::Mat1f& elevation,
                             const cv::Mat1f& grass,
                             double cell_size_m,
                             const HazardOptions& options);

}  // namespace freelsd
