// Private to approach/: the cells that the paths of one heading meet, counted from the touchdown's.
// Touchdowns lie at cell centres, so these are the same for all of them: what one check costs is
// looking up cells.
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
  // Over touchdown, of the lowest step in the cell.
  double path_height = 0.0;
  // How high something in the cell may stand over touchdown: least of the steps' path height less
  // the clearance wanted.
  double free_height = 0.0;
};

struct CircleCell {
  CellOffset offset;
  int num_steps = 0;
  // Most of the steps'.
  double wanted = 0.0;
};

// Of one wind scenario: cells in the order of flight from touchdown, and around both circles.
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

// One per heading of the wind.
std::vector<HeadingCells> MakeHeadingCells(const WindCase& wind,
                                           const ClearanceSurface& surface,
                                           const Aircraft& aircraft,
                                           const ApproachOptions& options);

// Cells of the surface under one touchdown.
class CellsBelow {
 public:
  CellsBelow(const ClearanceSurface& surface, int row, int col, double height)
      : surface_(surface), row_(row), col_(col), height_(height) {}

  bool IsRollFree(const std::vector<CellOffset>& ground_roll) const;
  // As CheckFinal until failure where the widened corridor is clear; nothing where it is not: that
  // takes a closer look.
  std::optional<PathCheck> GlanceAlongFinal(const PathCells& cells) const;
  // As CheckCircle until failure.
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
