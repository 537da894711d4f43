// Input: an accepted site and the world it is about. Output: how often a landing there fails, when
// it is flown with the errors of a pilot and of the wind.
//
// A flight follows the final at its planned angle and ends in the first contact. A contact with
// free ground from which the ground roll is free is a landing, however short. Everything else is a
// failure: a contact with anything else, and ground that is not free below the ground roll.
//
// The ground roll is the aircraft's, for the planned ground speed. The energy to brake away grows
// with the square of the ground speed, and so does the roll.
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "engine/selection/selection.h"
#include "tests/evaluation/statistics.h"
#include "tests/evaluation/truth_map.h"

namespace freelsd {

// Flights by the heights of the map: the path is where the plan says in world z, so a vertical
// error of the map moves the touchdown along the path.
struct AbsoluteFlights {
  int num_failed = 0;
  int num_failed_thin = 0;
  // Landings on free ground, but before or beyond the touchdown disc.
  int num_short = 0;
  int num_long = 0;
  // Of all landings: metres from the planned touchdown, positive beyond it.
  Sums landing_place;
};

// Failures that fences, poles or wires alone cause are counted as thin only.
struct FlownSite {
  int num_flown = 0;
  int num_failed = 0;
  int num_failed_thin = 0;
  // "final: tree", "roll: ditch": what was met first.
  std::map<std::string, int> causes, thin_causes;
  // World z of the planned touchdown less the true ground there.
  double height_bias = 0.0;
  AbsoluteFlights absolute;
};

// The site must have an approach. Flies 200 times; the series depends on the seed alone.
FlownSite FlySite(const World& world,
                  const TruthMap& truth,
                  const Aircraft& aircraft,
                  const Site& site,
                  uint64_t seed);

}  // namespace freelsd
