// Private to recorded/: how far two outlines of the same object differ.
#pragma once

#include "tests/evaluation/fields/labelled_ground.h"

namespace freelsd {

// Mean distance from points on the border of each to the border of the other, metres.
double MeanBorderDistance(const Polygon& a, const Polygon& b);

enum class Tallness { kLow, kTall };  // at most kMaxLowHeightM, or more

// Over all pairs of views of all objects of that height.
Disagreement DisagreementOf(const std::vector<LabelledObject>& objects,
                            const Grid& grid,
                            Tallness tallness);

}  // namespace freelsd
