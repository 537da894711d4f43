// Input: a world, the engine's run over it, and steps of the engine that are switched off. Output:
// what the engine answers without each step.
#pragma once

#include <cstdint>
#include <string>

#include <nlohmann/json.hpp>

#include "tests/evaluation/engine_run.h"
#include "tests/evaluation/synthetic_flight.h"
#include "tests/evaluation/truth_map.h"

namespace freelsd {

struct Ablations {
  // How each step is switched off: {name: {"options": merged into the engine's options, "aircraft":
  // merged into the aircraft}, ...}.
  nlohmann::json steps;
  // Of the run itself.
  nlohmann::json engine_options;
};

// {name: {num_found, num_accepted, num_false_safe, num_only_thin, num_flown, num_failed,
// num_missed_things, num_landings, log_loss, log_loss_of_all, free cells of each true kind}, ...},
// with "none" for the run itself. The losses are sums over the landings of DrawLandings that were
// seen with and without the step: of the risk without it, and of the run's own. The backend works
// again for each step, on the same views.
nlohmann::json CountAblations(const Scenario& scenario,
                              const TruthMap& truth,
                              const Fields& fields,
                              const EngineRun& run,
                              const Ablations& ablations,
                              uint64_t seed);

// Sums over records; empty if none has such counts. `failure_ratio` is a share of the flights;
// `log_loss_change` is the mean per landing without the step, less the mean with it.
nlohmann::json AblationTotals(const nlohmann::json& records);

}  // namespace freelsd
