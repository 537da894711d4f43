// Input: a pool. Output: its labelled photographs.
#pragma once

#include <vector>

#include "server/training/pools.h"
#include "tests/evaluation/frames/labelled_picture.h"

namespace freelsd {

// Tuning: $FREELSD_DATA/grass. Report: the polygons of tests/evaluation/places on
// $FREELSD_DATA/places, but for places of another scale. Reduced to `ground_sampling_m`; coarser
// photographs are left out. Every place is added to `run`. Throws std::runtime_error with what is
// missing.
std::vector<LabelledPicture> ReadRecordedPictures(Pool pool,
                                                  double ground_sampling_m,
                                                  PoolOfRun& run);

}  // namespace freelsd
