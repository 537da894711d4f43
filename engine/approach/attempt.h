// Private to approach/: evaluates one touchdown point with one heading.
#pragma once

#include <optional>
#include <vector>

#include "engine/approach/path_cells.h"
#include "engine/approach/touchdown.h"

namespace freelsd {

struct RiskBasis;

// Inputs common to all attempts in one region.
struct AttemptContext {
  const ClearanceSurface& surface;
  const WindCase& wind;
  const Aircraft& aircraft;
  const ApproachOptions& options;
  // One element per heading in `wind`.
  const std::vector<HeadingCells>& cells;
  const RiskBasis& risk;
};

struct Attempt {
  Touchdown touchdown;
  // Index into the headings of `wind`.
  size_t heading_index = 0;
  double heading = 0.0;
  Verdict verdict = Verdict::kRejected;
  std::optional<RejectReason> reason;
  LoiterDirection direction = LoiterDirection::kLeft;
  // Set by WithRisk. Everything else is fine then.
  bool is_risk_too_high = false;
  std::optional<RollHazard> roll_hazard;
  // Both are the worst over all wind scenarios. The circle has the chosen direction.
  PathCheck final_path;
  PathCheck circle;
};

Attempt Try(const Touchdown& touchdown,
            size_t heading_index,
            const AttemptContext& context,
            Depth depth);

Attempt BestHeading(const Touchdown& touchdown, const AttemptContext& context);

// Includes clearances, but not the strip, obstacle and profile of Explanation::kFull.
Approach DescribeApproach(const Attempt& attempt, const AttemptContext& context);

// The approach in each wind scenario of the attempt's heading, without clearances. The first one is
// flown.
std::vector<Approach> ApproachesOf(const Attempt& attempt, const AttemptContext& context);

// The tightest obstacle on one part of the path, in all scenarios of the attempt's heading.
std::optional<PathObstacle> TightestOf(const Attempt& attempt,
                                       const AttemptContext& context,
                                       PathPart part);

}  // namespace freelsd
