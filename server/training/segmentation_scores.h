// Scores of the segmentation on labelled photographs.
#pragma once

#include <nlohmann/json.hpp>

#include "server/training/labelled_photographs.h"

namespace freelsd {

// Returns three numbers over all photographs, and by place. covered: share of labelled grass that
// lies in a region, mean over the photographs with grass. purity: share of the labelled pixels in
// regions that have the same class as most pixels of their region, with two classes: grass and not
// grass. grass_purity: the same share in regions that are mostly grass.
nlohmann::ordered_json SegmentationScores(const Photographs& photographs,
                                          const SegmentationOptions& options);

}  // namespace freelsd
