// Input: an engine's run over one world. Output: everything that is scored of it, as JSON that can
// be added up with that of other worlds.
#pragma once

#include <nlohmann/json.hpp>

#include "tests/evaluation/engine_run.h"
#include "tests/evaluation/synthetic_flight.h"
#include "tests/evaluation/truth_map.h"

namespace freelsd {

// Of a run that ends with its map: poses, maps, heights and seconds alone.
nlohmann::json HeightsRecord(uint64_t seed,
                             const Scenario& scenario,
                             const EngineRun& run,
                             const TruthMap& truth);

// `options`: of the run; the planner is asked once more with them.
nlohmann::json WorldRecord(uint64_t seed,
                           const Scenario& scenario,
                           const EngineRun& run,
                           const TruthMap& truth,
                           const Fields& fields,
                           const PipelineOptions& options);

}  // namespace freelsd
