// Feature rows of a region.
#pragma once

#include <limits>

#include "engine/classification/classification.h"

namespace freelsd {

// Length of a feature row.
size_t NumFeatures(FeatureSet feature_set);

// A region is unsure if one of its features lies too far outside the range of this feature in the
// training grass. The allowed distances are shares of that range.
struct RangeMargin {
  float below = 0.0f;
  float above = 0.0f;
  // A region with a value below this bound is unsure. The bound does not depend on the training
  // grass.
  float least = std::numeric_limits<float>::lowest();
};
RangeMargin MarginOf(FeatureSet feature_set, size_t feature);
// Number of leading features that the forest uses. The rest only detect regions unlike the training
// grass.
size_t NumForestFeatures(FeatureSet feature_set);

}  // namespace freelsd
