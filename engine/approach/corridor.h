// Private to approach/: samples along and across a strip of ground, dense enough to miss no cell.
#pragma once

#include <vector>

#include <Eigen/Core>

namespace freelsd {

// Spacing of samples along and across a corridor, in cells. The centre of each cell has a sample
// within half a cell, so no cell is missed.
inline constexpr double kAlongSpacing = 0.5;
inline constexpr double kAcrossSpacing = 0.86;

// Samples across a corridor. They reach half a cell diagonal beyond the half-width, so that they
// also find cells of which only a corner lies in the corridor.
struct Corridor {
  // To the right of the heading; unit length.
  Eigen::Vector2d across = Eigen::Vector2d::Zero();
  double spacing = 0.0;
  int num_each_side = 0;

  // Distance from the middle to the outermost sample.
  double Reach() const { return num_each_side * spacing; }
};

Corridor MakeCorridor(double heading, double half_width, double cell_size);

// Distances from `from` to `to`, ascending, both ends included; the last step may be shorter.
std::vector<double> Steps(double from, double to, double step);

}  // namespace freelsd
