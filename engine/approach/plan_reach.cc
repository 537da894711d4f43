#include <algorithm>
#include <cmath>

#include "engine/approach/approach_geometry.h"

namespace freelsd {
namespace {

// Corridor, ground roll and position margin beside and behind the path.
constexpr double kMarginM = 60.0;
// Near winds then need the same part of a map.
constexpr double kStepM = 100.0;

}  // namespace

double PlanReach(const Aircraft& aircraft,
                 const std::optional<Eigen::Vector2d>& wind_in_world,
                 double wind_spread_mps,
                 double least,
                 const ApproachOptions& options) {
  double reach = least;
  const double wind_margin = options.wind_sigma * wind_spread_mps;
  for (const Way& way : WaysDown(wind_in_world, aircraft, options, wind_margin)) {
    if (way.start_height > 0) break;
    for (const WindScenario& scenario : way.Scenarios()) {
      const double path = std::max(scenario.approach_distance, 0.0) + 2.0 * scenario.loiter_radius;
      reach = std::max(reach, path + kMarginM);
    }
  }
  return kStepM * std::ceil(reach / kStepM);
}

}  // namespace freelsd
