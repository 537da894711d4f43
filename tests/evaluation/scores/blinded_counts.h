// Input: an engine's run over a world. Output: what the judge says of the run's map as it is, and
// of the same map made wrong in each way, planned on in the same places.
#pragma once

#include <nlohmann/json.hpp>

#include "tests/evaluation/scores/blinding.h"

namespace freelsd {

// {"shift": {num_accepted, num_false_safe, num_only_thin, num_flown, num_failed,
// num_failed_absolute, num_missed_absolute}, ...}. The flights are the series of the seed.
nlohmann::json CountBlinded(const Scenario& scenario,
                            const TruthMap& truth,
                            const Fields& fields,
                            const EngineRun& run,
                            const ApproachOptions& options,
                            uint64_t seed);

// Sums over records; empty if none has such counts. `failure_ratio`, `absolute_failure_ratio` and
// `absolute_missed_ratio` (short or long of the disc) are shares of the flights.
nlohmann::json BlindedTotals(const nlohmann::json& records);

}  // namespace freelsd
