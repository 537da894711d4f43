// Pictures for people: the world with what the engine answered, and the engine's own map beside it.
#pragma once

#include <string>

#include "tests/evaluation/engine_run.h"
#include "tests/evaluation/synthetic_flight.h"
#include "tests/evaluation/truth_map.h"

namespace freelsd {

// Writes DIR/NAME-world.png, -truth.png, -hazard.png and -elevation.png, north up, one kind of
// line: finals and ground rolls of sites (green landable, yellow unverified, red rejected; white
// circles are touchdown discs).
void DrawWorld(const std::string& folder,
               const std::string& name,
               const Scenario& scenario,
               const EngineRun& run,
               const TruthMap& truth,
               const Fields& fields);

}  // namespace freelsd
