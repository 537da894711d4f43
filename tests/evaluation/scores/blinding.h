// Input: the map of an engine's run. Output: the map made wrong on purpose, and what is planned on
// it. The judge must notice each error: as more false safe sites, or, for `heights`, as landings by
// absolute heights that miss the disc. Heights above a touchdown that are too large make a planner
// reject more; they cannot make a site false safe, because heights count from the touchdown.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tests/evaluation/engine_run.h"
#include "tests/evaluation/synthetic_flight.h"
#include "tests/evaluation/truth_map.h"

namespace freelsd {

enum class Blinding {
  kNone,     // nothing: what the others are compared with
  kHazards,  // all seen ground is free
  kShift,    // the map lies 5 m too far east
  kKinds,    // free ground and hazard are exchanged
  kHeights,  // what is above the median height is twice as high above it
  kFlat,     // what is above the median height has that height
};

// "none", "hazards", "shift", "kinds", "heights", "flat".
std::vector<std::string> BlindingNames();
std::optional<Blinding> BlindingNamed(const std::string& name);
std::string NameOf(Blinding blinding);

// Copies; grass and the distance to hazard fit the new hazards.
AssessedMap Blinded(const ElevationMap& map, const HazardLayers& layers, Blinding blinding);

// The run with its map made wrong, and with new sites: one for the rectangle of each true field and
// of each of the ten largest decoys, so that something can be accepted that must not be.
EngineRun RunBlinded(const Scenario& scenario,
                     const TruthMap& truth,
                     const Fields& fields,
                     const EngineRun& run,
                     Blinding blinding,
                     const ApproachOptions& options);

}  // namespace freelsd
