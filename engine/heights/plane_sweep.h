// Private to heights/. How much the views of a tile of ground differ, height by height.
#pragma once

#include <optional>
#include <vector>

#include "engine/heights/ground_photographs.h"
#include "engine/heights/proposal_surface.h"
#include "engine/heights/view_choice.h"

namespace freelsd {

// Samples and blocks of a map. Blocks are squares of map cells that share their views.
struct SampleGrid {
  Grid grid;
  int samples_per_cell = 5;
  int cells_per_block = 2;

  int SamplesPerBlock() const { return samples_per_cell * cells_per_block; }
  double SampleM() const { return grid.cell_size_m / samples_per_cell; }
};

SampleGrid SampleGridOf(const Grid& grid);

// A square of blocks, in cells of the map; a part of it may lie outside the grid.
struct SweptTile {
  cv::Rect cells;
  // Metres above the proposal surface, ascending, evenly spaced.
  std::vector<double> heights;
  // By height, one value per sample: variance between the views and mean square of log brightness;
  // both 0 where fewer than two views are compared.
  std::vector<cv::Mat1f> variance, power;
  // By block.
  cv::Mat1f num_views, baseline_ratio;
};

class PlaneSweep {
 public:
  PlaneSweep(const ProposalSurface& surface,
             const SampleGrid& samples,
             const AdjustedBlock& block,
             GroundPhotographs& photographs);
  // Nothing if fewer than two views see any block. `cells`: a whole number of blocks.
  std::optional<SweptTile> Sweep(const cv::Rect& cells);

 private:
  struct View;
  struct LiftedBlock;
  std::vector<View> ViewsAround(const cv::Rect& cells);
  LiftedBlock Lift(const cv::Rect& cells, const std::vector<View>& views) const;
  std::vector<double> HeightsFor(double baseline_ratio) const;

  const ProposalSurface& surface_;
  SampleGrid samples_;
  const AdjustedBlock& block_;
  GroundPhotographs& photographs_;
};

}  // namespace freelsd
