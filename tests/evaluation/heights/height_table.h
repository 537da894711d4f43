// Input: what was measured in the cells of worlds, and the truth. Output: the table of
// engine/heights/likelihood_table.h.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "engine/heights/likelihood.h"
#include "tests/evaluation/scores/map_shift.h"
#include "tests/evaluation/synthetic_flight.h"
#include "tests/evaluation/truth_map.h"

namespace freelsd {

class HeightTable {
 public:
  // Cells of open ground count as empty. Cells with a thing whose height the measured ground does
  // not have count as such.
  void Add(const Scenario& scenario,
           const TruthMap& truth,
           const PhotographHeights& heights,
           const MapOffset& offset);
  // Lines of C++.
  std::string Text() const;

 private:
  std::array<int64_t, kNumTableBins> num_things_{}, num_empty_{};
  int64_t num_all_things_ = 0, num_all_empty_ = 0;
};

}  // namespace freelsd
