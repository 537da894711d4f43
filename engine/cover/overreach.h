// Private to cover/. Finds where segments of meadow extend across a soft border into other ground.
#pragma once

#include "engine/cover/cover.h"
#include "engine/cover/photo_features.h"

namespace freelsd {

// Finds grass cells whose colour is nearer to the surrounding other ground than to the surrounding
// grass (Fisher's discriminant of two classes). Cells where the two surroundings have nearly the
// same colour are left out. `grass`: posterior as in HazardLayers, 0 where a rule found a crop or
// water. The result has one value per cell of `grid`: 255 for a found cell, else 0.
cv::Mat1b OverreachingGrass(const cv::Mat1f& grass,
                            const Orthophoto& photo,
                            const Grid& grid,
                            const CoverOptions& options);

// By how much the colour of each cell is more likely in the other ground around it than in the
// grass around it: the logarithm of the ratio of two Gaussian likelihoods with a shared variance.
// NaN unless both colours are known.
cv::Mat1f OtherGroundLogRatio(const cv::Mat1b& is_grass,
                              const cv::Mat1b& is_other,
                              const ColorsOnMap& on_map,
                              const Grid& grid,
                              const CoverOptions& options);

}  // namespace freelsd
