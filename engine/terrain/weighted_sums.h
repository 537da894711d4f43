// Private to terrain/. Sums over the points near a cell's centre, weighted by inverse squared
// distance.
#pragma once

#include <vector>

#include "engine/terrain/terrain.h"

namespace freelsd {

// A point this near to a cell's centre decides its height alone.
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

// The paper's mean needs weight and height only.
enum class SumKind { kMeanOnly, kAll };

// Sums over the cells of a rectangle. Each processor gives the same result to the bit; the sums
// depend on the order of the points.
class WeightedSums {
 public:
  // `cells`: x = col, y = row. Heights are summed relative to base_height.
  WeightedSums(
      const Grid& grid, const cv::Rect& cells, double radius_m, double base_height, SumKind kind);

  // Skips points that are not finite or reach no cell.
  void Add(const DensePoint* points, size_t num_points);

  const cv::Rect& cells() const { return cells_; }
  double base_height() const { return base_height_; }
  // Row and column count from the rectangle's corner. kMeanOnly fills only weight and height.
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
  // A ring of unused cells surrounds the cells, so that points at the border need no test.
  int stride_;
  // The slots of a cell share one cache line.
  struct alignas(4 * sizeof(double)) FourSlots {
    double slots[4] = {};
  };
  std::vector<FourSlots> sums_;
  // Number of points and variance of each cell.
  std::vector<double> tallies_;
};

}  // namespace freelsd
