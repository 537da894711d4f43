// Private to approach/: the cells below the paths of one heading, as offsets from the touchdown's
// cell. Every touchdown is at the centre of a cell. The offsets are therefore the same for all
// touchdowns, and are computed only once.
#pragma once

#include <array>
#include <vector>

#include "engine/approach/path_check.h"

namespace freelsd {

// Rows south and columns east of the touchdown's cell.
struct CellOffset {
  int row = 0;
  int col = 0;
};

struct FinalCell {
  CellOffset offset;
  // Height of the path above touchdown, at the lowest step in the cell.
  double path_height = 0.0;
  // Greatest allowed height of an object in the cell, above touchdown. For each step in the cell,
  // the needed clearance is subtracted from the path height. The least result counts.
  double free_height = 0.0;
};

struct CircleCell {
  CellOffset offset;
  int num_steps = 0;
  // Largest clearance that a step in the cell needs.
  double wanted = 0.0;
};

// Cells of one wind scenario: along the final in order from touchdown, and along both circles.
struct PathCells {
  std::vector<FinalCell> final_path;
  int num_final_steps = 0;
  std::array<std::vector<CircleCell>, 2> circles;  // by LoiterDirection
  std::array<int, 2> num_circle_steps{};
};

struct HeadingCells {
  std::vector<CellOffset> ground_roll;
  std::vector<PathCells> scenarios;
};

// One per heading in `wind`.
std::vector<HeadingCells> MakeHeadingCells(const WindCase& wind,
                                           const ClearanceSurface& surface,
                                           const Aircraft& aircraft,
                                           const ApproachOptions& options);

// Checks the paths to one touchdown by looking up the cells below them. `row` and `col` are the
// touchdown's cell in the surface, `height` is its world z.
class CellsBelow {
 public:
  CellsBelow(const ClearanceSurface& surface, int row, int col, double height)
      : surface_(surface), row_(row), col_(col), height_(height) {}

  bool IsRollFree(const std::vector<CellOffset>& ground_roll) const;
  // Quick test with a widened corridor (ClearanceSurface::corridor_height). If this corridor is
  // clear, the result equals that of CheckFinal with kUntilFailure. Otherwise returns nothing, and
  // the caller must call CheckFinal.
  std::optional<PathCheck> GlanceAlongFinal(const PathCells& cells) const;
  // Like the free function CheckCircle, but stops at the first obstacle.
  PathCheck CheckCircle(const PathCells& cells,
                        LoiterDirection direction,
                        double approach_height) const;

 private:
  const ClearanceSurface& surface_;
  int row_;
  int col_;
  double height_;
};

}  // namespace freelsd
