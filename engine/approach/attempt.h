// Private to approach/: one touchdown point with one heading, tried.
#pragma once

#include <optional>
#include <string>

#include "engine/approach/path_cells.h"
#include "engine/approach/touchdown.h"

namespace freelsd {

// What all attempts of one region share.
struct AttemptContext {
  const ClearanceSurface& surface;
  const WindCase& wind;
  const Aircraft& aircraft;
  const ApproachOptions& options;
  // One per heading of the wind.
  const std::vector<HeadingCells>& cells;
};

struct Attempt {
  Touchdown touchdown;
  // Among the wind's.
  size_t heading_index = 0;
  double heading = 0.0;
  Verdict verdict = Verdict::kRejected;
  std::optional<RejectReason> reason;
  LoiterDirection direction = LoiterDirection::kLeft;
  std::optional<RollHazard> roll_hazard;
  // Over all scenarios of the wind; the circle is that of the chosen direction.
  PathCheck final_path;
  PathCheck circle;
};

Attempt Try(const Touchdown& touchdown,
            size_t heading_index,
            const AttemptContext& context,
            Depth depth);

// Of all headings the best attempt.
Attempt BestHeading(const Touchdown& touchdown, const AttemptContext& context);

// By verdict, then by clearance and unseen share; rejected ones by how far they came.
bool IsBetter(const Attempt& a, const Attempt& b);

// Why it was not taken, in a sentence with numbers.
Rejection Explain(const Attempt& attempt, const AttemptContext& context);

// With clearances, without profile.
Approach DescribeApproach(const Attempt& attempt, const AttemptContext& context);

}  // namespace freelsd
