// Feature rows of a region.
#pragma once

#include "engine/classification/classification.h"

namespace freelsd {

// Length of a feature row.
size_t NumFeatures(FeatureSet feature_set);
// How many of them, from the first, the forest sees. The rest only guard against what is unlike
// the grass of the training data.
size_t NumForestFeatures(FeatureSet feature_set);

}  // namespace freelsd
