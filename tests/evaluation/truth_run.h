// Input: a world. Output: what the planner answers on maps without error, of the ground that the
// flight would see: a bound of what any engine could find by the same rules.
#pragma once

#include "tests/evaluation/engine_run.h"
#include "tests/evaluation/synthetic_flight.h"
#include "tests/evaluation/truth_map.h"

namespace freelsd {

// One site per field, touching down within it, in the true wind. Maps have the deviation that
// blocks of such flights state, so the planner keeps the same margins.
EngineRun RunOnTruth(const Scenario& scenario,
                     const TruthMap& truth,
                     const Fields& fields,
                     const ApproachOptions& options);

}  // namespace freelsd
