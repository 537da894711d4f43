// Input: an engine's map and the world it is about. Output: how often landings fail, beside how
// often the engine expects it, for landings drawn over the whole range of risk.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <nlohmann/json.hpp>

#include "tests/evaluation/engine_run.h"
#include "tests/evaluation/synthetic_flight.h"
#include "tests/evaluation/truth_map.h"

namespace freelsd {

// A landing at a random place of the map, into the wind, where final and roll were seen.
struct DrawnLanding {
  // With the approach of its plan, and the wind.
  Site site;
  LandingRisk risk;
  // Shares of the flights that failed, and that failed by thin things alone.
  double observed = 0.0;
  double observed_thin = 0.0;
};

// Of each bin of the expected risk at most some are flown. Empty without a map.
std::vector<DrawnLanding> DrawLandings(const EngineRun& run,
                                       const Scenario& scenario,
                                       const TruthMap& truth,
                                       const ApproachOptions& options,
                                       uint64_t seed);

// The risk of a drawn landing on the map of another run. Nothing where that map does not show it.
std::optional<LandingRisk> RiskAt(const Site& site,
                                  const EngineRun& run,
                                  const Aircraft& aircraft,
                                  const ApproachOptions& options);

// Log loss of an expected risk, of which no more than 1e-4 is believed to be certain.
double LogLoss(double expected, double observed);

// [[expected, observed, observed by thin things alone], ...] of DrawLandings.
nlohmann::json LandingRisksJson(const EngineRun& run,
                                const Scenario& scenario,
                                const TruthMap& truth,
                                const ApproachOptions& options,
                                uint64_t seed);

// By bins of the expected risk: number of landings, expected and observed failures per landing with
// an interval (bootstrap over worlds).
nlohmann::json LandingRiskTotals(const nlohmann::json& records);

}  // namespace freelsd
