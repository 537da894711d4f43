// Input: an adjusted block. Output: the block as it would be if its poses were true.
#pragma once

#include "engine/adjustment/adjustment.h"
#include "tests/evaluation/synthetic_flight.h"

namespace freelsd {

// Poses and camera are the scenario's, and deviations of the whole block are zero. Landmarks are
// triangulated again from where they appear in the photographs. The connected views are one group.
// What a camera turns while it reads an image stays as it was estimated.
AdjustedBlock WithTruePoses(AdjustedBlock block, const Scenario& scenario);

}  // namespace freelsd
