// Private to terrain/. Sums over the points near a cell's centre, weighted by inverse squared
// distance.
#pragma once

#include <vector>

#include "engine/terrain/terrain.h"

namespace freelsd {

// If a point is closer than this to a cell's centre, only this point determines the cell's height.
constexpr double kExactHitM = 1e-6;

struct CellSums {
  // Heights are relative to base_height.
  double weight = 0.0;
  double height = 0.0;
  double squared_height = 0.0;
  double num_points = 0.0;
  // Unweighted sum of the points' own variances.
  double variance = 0.0;
};

// kMeanOnly: only weight and height, which suffice for the paper's mean.
enum class SumKind { kMeanOnly, kAll };

// Sums for the cells of a rectangle. They are bitwise equal on every processor, but depend on the
// order of the points.
class WeightedSums {
 public:
  // `cells`: the rectangle; x = col, y = row. Heights are summed relative to base_height.
  WeightedSums(
      const Grid& grid, const cv::Rect& cells, double radius_m, double base_height, SumKind kind);

  // Skips points that are not finite or reach no cell.
  void Add(const DensePoint* points, size_t num_points);

  const cv::Rect& cells() const { return cells_; }
  double base_height() const { return base_height_; }
  // `row` and `col` are relative to the rectangle's corner. With kMeanOnly only weight and height
  // are set.
  CellSums At(int row, int col) const;

 private:
  void AddNear(const DensePoint* points, size_t num_points);
  void AddWide(const DensePoint& point);
  size_t IndexOf(int row, int col) const;
  const double* Slots(size_t cell) const {
    return reinterpret_cast<const double*>(sums_.data()) + cell * num_slots_;
  }
  double* Slots(size_t cell) { return reinterpret_cast<double*>(sums_.data()) + cell * num_slots_; }

  cv::Rect cells_;
  double west_, north_, cell_size_, radius_, base_height_;
  SumKind kind_;
  size_t num_slots_;
  // A border of unused cells surrounds the rectangle, so that points at its edge need no check.
  int stride_;
  // The slots of a cell share one cache line.
  struct alignas(4 * sizeof(double)) FourSlots {
    double slots[4] = {};
  };
  std::vector<FourSlots> sums_;
  // For each cell: number of points, sum of their variances.
  std::vector<double> tallies_;
};

}  // namespace freelsd
