// Private to heights/. What a swept tile tells of each of its cells.
#pragma once

#include "engine/heights/plane_sweep.h"

namespace freelsd {

HeightEvidence EmptyEvidence(const Grid& grid);

struct SweepGround {
  const ElevationMap& proposal;
  const ProposalSurface& surface;
  const SampleGrid& samples;
};

// Writes the cells of the tile that are `core`, which lies in the grid. The tile is wider than its
// core by half a window or more.
void MeasureCells(const SweptTile& tile,
                  const cv::Rect& core,
                  const SweepGround& ground,
                  const HeightsOptions& options,
                  HeightEvidence& evidence);

}  // namespace freelsd
