// Feature rows of a region.
#pragma once

#include <limits>

#include "engine/classification/classification.h"

namespace freelsd {

// Length of a feature row.
size_t NumFeatures(FeatureSet feature_set);

// How far a feature may lie outside its range over the training grass, as shares of that range. A
// region with a feature farther outside is unsure.
struct RangeMargin {
  float below = 0.0f;
  float above = 0.0f;
  // A region with a smaller value is unsure, whatever the range of the training grass.
  float least = std::numeric_limits<float>::lowest();
};
RangeMargin MarginOf(FeatureSet feature_set, size_t feature);
// Number of leading features that the forest uses. The rest only detect regions unlike the training
// grass.
size_t NumForestFeatures(FeatureSet feature_set);

}  // namespace freelsd
