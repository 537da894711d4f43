#include "engine/heights/heights.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/heights/cell_evidence.h"
#include "engine/heights/likelihood.h"

namespace freelsd {
namespace {

constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
// Blocks of a tile, without those beside it that its windows reach into.
constexpr int kCoreBlocks = 16;
constexpr int kReachCells = 2;

}  // namespace

PhotographHeights MeasureHeights(const ElevationMap& proposal,
                                 const AdjustedBlock& block,
                                 const ImageSource& images,
                                 const HeightsOptions& options) {
  options.Check();
  PhotographHeights heights;
  heights.grid = proposal.grid;
  heights.evidence = EmptyEvidence(proposal.grid);
  const ProposalSurface surface(proposal, options.proposal_window_m);
  const SampleGrid samples = SampleGridOf(proposal.grid, options);
  GroundPhotographs photographs(block, images, samples.SampleM());
  PlaneSweep sweep(surface, samples, block, photographs, options);
  const int per_block = samples.cells_per_block;
  const int side = kCoreBlocks * per_block;
  const int halo = (kReachCells + per_block - 1) / per_block * per_block;
  const cv::Rect grid(0, 0, proposal.grid.num_cols, proposal.grid.num_rows);
  for (int top = 0; top < grid.height; top += side) {
    for (int left = 0; left < grid.width; left += side) {
      const cv::Rect core(left, top, side, side);
      const cv::Mat1f seen = proposal.elevation(core & grid);
      if (cv::countNonZero(seen == seen) == 0) continue;
      const auto tile = sweep.Sweep(
          {core.x - halo, core.y - halo, core.width + 2 * halo, core.height + 2 * halo});
      if (!tile) continue;
      MeasureCells(*tile, core & grid, {proposal, surface, samples}, options, heights.evidence);
    }
  }
  Judge(proposal, options, heights);
  return heights;
}

ElevationMap WithHeights(const ElevationMap& proposal, const PhotographHeights& heights) {
  ElevationMap map = proposal;
  map.elevation = proposal.elevation.clone();
  map.upper = proposal.upper.clone();
  map.standard_deviation = proposal.standard_deviation.clone();
  map.is_compared = true;
  for (int row = 0; row < map.elevation.rows; ++row) {
    for (int col = 0; col < map.elevation.cols; ++col) {
      if (!map.IsSeen(row, col)) continue;
      map.standard_deviation(row, col) = heights.standard_deviation(row, col);
      if (static_cast<CannotTell>(heights.cannot_tell(row, col)) != CannotTell::kNothing) {
        map.standard_deviation(row, col) = kUnknown;
        continue;
      }
      map.elevation(row, col) = heights.ground(row, col);
      map.upper(row, col) = std::max(heights.upper(row, col), heights.ground(row, col));
    }
  }
  return map;
}

ElevationMap DecideHeights(const ElevationMap& proposal,
                           const AdjustedBlock& block,
                           const ImageSource& images,
                           const HeightsOptions& options) {
  if (options.method == HeightMethod::kPairs) return proposal;
  return WithHeights(proposal, MeasureHeights(proposal, block, images, options));
}

}  // namespace freelsd
