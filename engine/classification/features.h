// Feature rows of a region.
#pragma once

#include "engine/classification/classification.h"

namespace freelsd {

// Length of a feature row.
size_t NumFeatures(FeatureSet feature_set);
}  // namespace freelsd
