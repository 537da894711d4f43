// Private to terrain/. Sums over the points near a cell's centre, weighted by inverse squared
// distance.
#pragma once

#include <vector>

#include "engine/terrain/terrain.h"

namespace freelsd {

// A point this near to a cell's centre decides its height alone; nearer makes no difference.
constexpr double kExactHitM = 1e-6;

struct CellSums {
  // Heights are relative to the base.
  double weight = 0.0;
  double height = 0.0;
  double squared_height = 0.0;
  double num_points = 0.0;
  // Not weighted: of the points' own errors.
  double variance = 0.0;
};

// What is summed: the paper's mean needs weight and height alone.
enum class SumKind { kMeanOnly, kAll };

// Sums of a rectangle of the grid's cells. Adding points costs the same to the bit on every
// processor; sums depend on the order of points as additions do.
class WeightedSums {
 public:
  // `cells`: x = col, y = row. Heights are summed relative to base_height.
  WeightedSums(
      const Grid& grid, const cv::Rect& cells, double radius_m, double base_height, SumKind kind);

  // Points that are not finite or reach no cell add nothing.
  void Add(const DensePoint* points, size_t num_points);

  const cv::Rect& cells() const { return cells_; }
  double base_height() const { return base_height_; }
  // Of a cell of the rectangle, counted from its corner; only weight and height of kMeanOnly.
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
  // Around the cells lies a ring that nobody asks for, so that no point needs a test of the border.
  int stride_;
  // Slots of a cell lie in one line of the cache.
  struct alignas(4 * sizeof(double)) FourSlots {
    double slots[4] = {};
  };
  std::vector<FourSlots> sums_;
  // Number of points and variance of each cell.
  std::vector<double> tallies_;
};

}  // namespace freelsd
