// Feature rows of a region.
#pragma once

#include <limits>

#include "engine/classification/classification.h"

namespace freelsd {

// Length of a feature row.
size_t NumFeatures(FeatureSet feature_set);

// How far outside the range of the training grass a feature may lie before nothing can be told, as
// shares of that range.
struct RangeMargin {
  float below = 0.0f;
  float above = 0.0f;
  // Nothing below it can be told either, whatever the training grass was.
  float least = std::numeric_limits<float>::lowest();
};
RangeMargin MarginOf(FeatureSet feature_set, size_t feature);
// How many of them, from the first, the forest sees. The rest only guard against what is unlike
// the grass of the training data.
size_t NumForestFeatures(FeatureSet feature_set);

}  // namespace freelsd
