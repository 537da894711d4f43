// What each view says of grass, as the map asks for it. Private to the pipeline.
#pragma once

#include <vector>

#include "engine/pipeline.h"

namespace freelsd {

// The fine mask of a view for the map: 0 where no region was sure, else the region's probability.
cv::Mat1b GrassMask(const Segments& segments, const Labels& labels);

PackedMask Packed(const cv::Mat1b& mask, double image_px_per_mask_px);

// The masks of the adjusted views, with their adjusted poses and camera. `indices`: of the block's
// views in the snapshot.
std::vector<GrassView> AdjustedGrassViews(const Snapshot& snapshot,
                                          const std::vector<size_t>& indices,
                                          const AdjustedBlock& block);

}  // namespace freelsd
