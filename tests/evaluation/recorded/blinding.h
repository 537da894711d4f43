// Input: a map and its layers. Output: the same with one part of what the engine knows made wrong.
// A score that counts no more false safe sites on it cannot tell danger.
#pragma once

#include <string>
#include <vector>

#include "engine/hazard/hazard.h"

namespace freelsd {

enum class Blinding {
  kHazards,  // every seen cell is free grass
  kShift,    // the map lies 5 m east of where it is
  kKinds,    // free cells are hazards, and hazards are free grass
  kHeights,  // heights above the median, and of what stands on the ground, are doubled
  kFlat,     // every seen cell is as high as the median: nothing blocks a path
};
std::vector<Blinding> AllBlindings();
const char* NameOf(Blinding blinding);
// Throws std::invalid_argument.
Blinding BlindingNamed(const std::string& name);

AssessedMap Blinded(AssessedMap map, Blinding blinding);

}  // namespace freelsd
