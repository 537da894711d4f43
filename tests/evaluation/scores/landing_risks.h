// Input: an engine's map and the world it is about. Output: how often landings fail, beside how
// often the engine expects it, for landings drawn over the whole range of risk; and how often
// ground that is called grass is not fit to land on, by its shape.
#pragma once

#include <cstdint>

#include <nlohmann/json.hpp>

#include "tests/evaluation/engine_run.h"
#include "tests/evaluation/synthetic_flight.h"
#include "tests/evaluation/truth_map.h"

namespace freelsd {

struct DrawnSeries {
  uint64_t seed = 0;
  // Error of the map's position, world.
  Eigen::Vector2d map_shift = Eigen::Vector2d::Zero();
};

// {"landings": [[expected, observed, observed by thin things alone], ...], "shapes": [[cells, unfit
// cells], ...]}. Touchdowns lie at random on the map, where disc, roll and final were seen; the
// headings are into the wind, or any. Of each bin of the expected risk at most a few are flown.
nlohmann::json LandingRisksJson(const EngineRun& run,
                                const Scenario& scenario,
                                const TruthMap& truth,
                                const PipelineOptions& options,
                                const DrawnSeries& series);

// By bins of the expected risk: number of landings, expected and observed failures per landing with
// an interval (bootstrap over worlds). By bins of the shape's ratio: cells, and share of unfit
// ones.
nlohmann::json LandingRiskTotals(const nlohmann::json& records);

}  // namespace freelsd
