// Input: a world. Output: the largest pieces of ground that are no meadow, as regions: what an
// engine must reject.
#pragma once

#include <vector>

#include "engine/regions/regions.h"
#include "tests/evaluation/synthetic_flight.h"
#include "tests/evaluation/truth_map.h"

namespace freelsd {

// Connected photographed cells of one cover, of at least the aircraft's least area; largest first.
// Ids count from `first_id`.
std::vector<Region> LargestDecoys(const Scenario& scenario,
                                  const TruthMap& truth,
                                  size_t max_num_decoys,
                                  int first_id);

}  // namespace freelsd
