// Private to approach/: heights that a path must clear, cut out of the map around one region.
#pragma once

#include <cmath>
#include <vector>

#include "engine/approach/approach_geometry.h"

namespace freelsd {

// An unknown height. It is below every real height, so that a maximum over cells ignores it.
constexpr float kNoHeight = -1e30f;

// Used instead of std::floor, because millions of cells are looked up. On baseline x86, std::floor
// is a function call.
inline int FloorOf(double value) {
  const int truncated = static_cast<int>(value);
  return truncated - (value < truncated ? 1 : 0);
}

struct ClearanceSurface {
  // Outer corner of cell (0, 0), which is cell (first_row, first_col) of the map.
  Eigen::Vector2d north_west_in_world = Eigen::Vector2d::Zero();
  double cell_size = 1.0;
  int first_row = 0;
  int first_col = 0;
  // Upper height of the cell, world z, or kNoHeight. Includes unclear_height_allowance_m if the
  // cell has no clear class (ClearClassOptions).
  cv::Mat1f height;
  // 1 where the height is unknown or too uncertain.
  cv::Mat1b is_unseen;
  // Values of Hazard.
  cv::Mat1b hazard;
  // For each cell: the maximum of height, and of is_unseen, over all cells within corridor_radius.
  // Used to check circles, and for a quick test of finals.
  cv::Mat1f corridor_height;
  cv::Mat1b corridor_is_unseen;
  // Metres, from cell centre to cell centre. From the cell below a point of the path, no cell that
  // the corridor reaches at this point is farther away than this.
  double corridor_radius = 0.0;
  // Additional clearance per metre of distance from touchdown, because the map may be tilted.
  double lean = 0.0;
  // Step along the circle, metres.
  double circle_step = 0.5;

  int num_rows() const { return height.rows; }
  int num_cols() const { return height.cols; }
  bool IsInside(int row, int col) const {
    return row >= 0 && row < height.rows && col >= 0 && col < height.cols;
  }
  int RowAt(double north) const { return FloorOf((north_west_in_world.y() - north) / cell_size); }
  int ColAt(double east) const { return FloorOf((east - north_west_in_world.x()) / cell_size); }
  Eigen::Vector2d CellCenter(int row, int col) const {
    return north_west_in_world + cell_size * Eigen::Vector2d(col + 0.5, -(row + 0.5));
  }
  // From a cell's centre to its corner.
  double HalfDiagonal() const { return cell_size * std::sqrt(0.5); }
};

// Covers every path to a touchdown within the footprint.
ClearanceSurface MakeClearanceSurface(const ElevationMap& map,
                                      const HazardLayers& hazards,
                                      const Polygon& footprint,
                                      const std::vector<WindScenario>& scenarios,
                                      const Aircraft& aircraft,
                                      const ApproachOptions& options);

// Covers the whole map. Its circle_step is path_step_m. It can be used only for scenarios whose
// CircleStep equals path_step_m.
ClearanceSurface MakeClearanceSurfaceOfMap(const ElevationMap& map,
                                           const HazardLayers& hazards,
                                           const Aircraft& aircraft,
                                           const ApproachOptions& options);
// Covers `cells` of the map. Only for straight paths, because corridor_height and
// corridor_is_unseen stay empty.
ClearanceSurface MakeHeightSurface(const ElevationMap& map,
                                   const HazardLayers& hazards,
                                   const cv::Rect& cells,
                                   const Aircraft& aircraft,
                                   const ApproachOptions& options);
// Step along the circles of the scenarios, metres. It is path_step_m, or more if the largest circle
// would have too many steps.
double CircleStep(const std::vector<WindScenario>& scenarios, const ApproachOptions& options);

}  // namespace freelsd
