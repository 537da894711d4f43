#include <algorithm>
#include <cmath>

#include "engine/heights/heights.h"
#include "engine/heights/plane_sweep.h"

namespace freelsd {
namespace {

// Neighbouring samples share pixels.
constexpr double kIndependentRatio = 0.5;
// Variance of log brightness that any camera has: keeps ratios finite.
constexpr float kLeastVariance = 1e-5f;
// Things narrower than this do not lift the surface that is searched from.
constexpr double kSurfaceWindowM = 9.0;

// The blocks around a cell, as many on each side.
cv::Rect BlocksAround(const cv::Point& cell, int cells_per_block) {
  const auto first = [cells_per_block](int index) {
    return (index / cells_per_block - 1) * cells_per_block;
  };
  return {first(cell.x), first(cell.y), 3 * cells_per_block, 3 * cells_per_block};
}

}  // namespace

std::optional<HeightLikelihood> HeightLikelihoodAt(const Eigen::Vector2d& place_in_world,
                                                   const ElevationMap& map,
                                                   const AdjustedBlock& block,
                                                   const ImageSource& images) {
  const auto cell = map.grid.CellAt(place_in_world);
  if (!cell || !map.IsSeen(cell->y, cell->x)) return std::nullopt;
  const ProposalSurface surface(map, kSurfaceWindowM);
  const SampleGrid samples = SampleGridOf(map.grid);
  GroundPhotographs photographs(block, images, samples.SampleM());
  PlaneSweep sweep(surface, samples, block, photographs);
  const cv::Rect cells = BlocksAround(*cell, samples.cells_per_block);
  const auto tile = sweep.Sweep(cells);
  if (!tile) return std::nullopt;
  const cv::Point in_tile = *cell - cells.tl();
  const cv::Point in_blocks(in_tile.x / samples.cells_per_block,
                            in_tile.y / samples.cells_per_block);
  const float num_views = tile->num_views(in_blocks);
  if (num_views < 2.0f) return std::nullopt;
  // The ground is compared in a window of two cells.
  const int side = samples.samples_per_cell;
  const cv::Rect window =
      cv::Rect(side * in_tile.x - side / 2, side * in_tile.y - side / 2, 2 * side, 2 * side) &
      cv::Rect({0, 0}, tile->variance.front().size());
  HeightLikelihood found;
  found.num_views = static_cast<int>(num_views);
  found.baseline_ratio = tile->baseline_ratio(in_blocks);
  const double num_independent =
      kIndependentRatio * window.area() * static_cast<double>(num_views - 1.0f);
  for (size_t h = 0; h < tile->heights.size(); ++h) {
    const double variance = cv::mean(tile->variance[h](window))[0] + kLeastVariance;
    const double power = cv::mean(tile->power[h](window))[0] + kLeastVariance;
    found.heights.push_back(surface.At(cell->y, cell->x) + tile->heights[h]);
    found.log_likelihood.push_back(-0.5 * num_independent * std::log(variance));
    found.correlation = std::max(found.correlation, 1.0 - variance / power);
  }
  const double best = *std::max_element(found.log_likelihood.begin(), found.log_likelihood.end());
  for (double& value : found.log_likelihood) value -= best;
  return found;
}

}  // namespace freelsd
