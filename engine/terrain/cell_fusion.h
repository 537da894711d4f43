// Private to terrain/. Fuses the summaries of all pairs in one cell.
#pragma once

#include <optional>
#include <vector>

#include "engine/terrain/pair_summary.h"

namespace freelsd {

struct FusedCell {
  double elevation = 0.0;
  double upper = 0.0;
  double standard_deviation = 0.0;
  double num_points = 0.0;
};

// The result does not depend on the order of the summaries. Nothing if too few points agree.
std::optional<FusedCell> FuseCell(std::vector<CellSummary> summaries,
                                  const TerrainOptions& options);

}  // namespace freelsd
