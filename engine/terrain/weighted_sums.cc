#include "engine/terrain/weighted_sums.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace freelsd {
namespace {

constexpr int kRing = 1;
// Slots of a cell: weight and height, or these with squared height, number of points, variance.
constexpr int kNumMeanSlots = 2;
constexpr int kNumSlots = 6;
// Points whose weights are found at a time; they stay in the first cache.
constexpr size_t kBatch = 256;

typedef double Two __attribute__((vector_size(2 * sizeof(double))));

// Where the points lie among the cells, in units of cells from the ring's corner.
struct Layout {
  double west, north, per_cell, base_height;
  double num_cols, num_rows;
  double cell_area, squared_radius;
  int stride;
};

// The cell whose centre is next to the north-west, and the weights for it and its neighbours to the
// east, south and south-east.
struct Batch {
  std::array<int, kBatch> slot;
  std::array<std::array<double, kBatch>, 4> weights;
  std::array<double, kBatch> height;
  std::array<double, kBatch> variance;
  // Not weighed: on a line of centres a point may be a whole radius from the centres on both sides.
  std::array<int, kBatch> is_on_line;
};

// Four reciprocals for one division: 1 / a = (b c d) / (a b c d). A processor divides slowly.
[[gnu::always_inline]] inline void Weigh(const DensePoint* points,
                                         size_t num_points,
                                         const Layout& layout,
                                         Batch& batch) {
  constexpr double kLeast = kExactHitM * kExactHitM;
  for (size_t i = 0; i < num_points; ++i) {
    const DensePoint& point = points[i];
    const double u = (point.point_in_world[0] - layout.west) * layout.per_cell;
    const double v = (layout.north - point.point_in_world[1]) * layout.per_cell;
    const double height = point.point_in_world[2] - layout.base_height;
    const bool is_inside = (u >= 0.0) & (v >= 0.0) & (u < layout.num_cols) & (v < layout.num_rows) &
                           (std::abs(height) <= std::numeric_limits<double>::max());
    const double u_in = is_inside ? u : 0.0, v_in = is_inside ? v : 0.0;
    const int col = static_cast<int>(u_in), row = static_cast<int>(v_in);
    const double west = u_in - col, east = west - 1.0, north = v_in - row, south = north - 1.0;
    const double a = std::max((west * west + north * north) * layout.cell_area, kLeast);
    const double b = std::max((east * east + north * north) * layout.cell_area, kLeast);
    const double c = std::max((west * west + south * south) * layout.cell_area, kLeast);
    const double d = std::max((east * east + south * south) * layout.cell_area, kLeast);
    const double ab = a * b, cd = c * d;
    const bool is_on_line = is_inside & ((west == 0.0) | (north == 0.0));
    const double reciprocal = is_inside & !is_on_line ? 1.0 / (ab * cd) : 0.0;
    batch.is_on_line[i] = is_on_line ? 1 : 0;
    batch.slot[i] = row * layout.stride + col;
    batch.weights[0][i] = a <= layout.squared_radius ? reciprocal * (b * cd) : 0.0;
    batch.weights[1][i] = b <= layout.squared_radius ? reciprocal * (a * cd) : 0.0;
    batch.weights[2][i] = c <= layout.squared_radius ? reciprocal * (ab * d) : 0.0;
    batch.weights[3][i] = d <= layout.squared_radius ? reciprocal * (ab * c) : 0.0;
    batch.height[i] = is_inside ? height : 0.0;
    batch.variance[i] =
        static_cast<double>(point.height_sd_m) * static_cast<double>(point.height_sd_m);
  }
}

void WeighPlain(const DensePoint* points, size_t num_points, const Layout& layout, Batch& batch) {
  Weigh(points, num_points, layout, batch);
}
using Weigher = void (*)(const DensePoint*, size_t, const Layout&, Batch&);

#if defined(__x86_64__)
// Without fused multiplications: every processor has the same rounding.
[[gnu::target("avx2")]] void WeighAvx2(const DensePoint* points,
                                       size_t num_points,
                                       const Layout& layout,
                                       Batch& batch) {
  Weigh(points, num_points, layout, batch);
}

Weigher FastestWeigher() { return __builtin_cpu_supports("avx2") != 0 ? WeighAvx2 : WeighPlain; }
#else
Weigher FastestWeigher() { return WeighPlain; }
#endif

[[gnu::always_inline]] inline void AddTwo(double* slot, Two value) {
  Two sum;
  __builtin_memcpy(&sum, slot, sizeof(Two));
  sum += value;
  __builtin_memcpy(slot, &sum, sizeof(Two));
}

void ScatterMean(const Batch& batch, size_t num_points, int stride, double* sums) {
  const int corners[4] = {0, 1, stride, stride + 1};
  for (size_t i = 0; i < num_points; ++i) {
    const Two term = {1.0, batch.height[i]};
    for (size_t k = 0; k < 4; ++k) {
      const double weight = batch.weights[k][i];
      AddTwo(sums + static_cast<ptrdiff_t>(batch.slot[i] + corners[k]) * kNumMeanSlots,
             Two{weight, weight} * term);
    }
  }
}

void ScatterAll(const Batch& batch, size_t num_points, int stride, double* sums) {
  const int corners[4] = {0, 1, stride, stride + 1};
  for (size_t i = 0; i < num_points; ++i) {
    const double height = batch.height[i], squared = height * height;
    for (size_t k = 0; k < 4; ++k) {
      const double weight = batch.weights[k][i];
      const double counts = weight > 0.0 ? 1.0 : 0.0;
      double* slots = sums + static_cast<ptrdiff_t>(batch.slot[i] + corners[k]) * kNumSlots;
      AddTwo(slots, Two{weight, weight * height});
      AddTwo(slots + 2, Two{weight * squared, counts});
      slots[4] += counts * batch.variance[i];
    }
  }
}

}  // namespace

WeightedSums::WeightedSums(
    const Grid& grid, const cv::Rect& cells, double radius_m, double base_height, SumKind kind)
    : cells_(cells),
      west_(grid.north_west_in_world.x() + cells.x * grid.cell_size_m),
      north_(grid.north_west_in_world.y() - cells.y * grid.cell_size_m),
      cell_size_(grid.cell_size_m),
      radius_(radius_m),
      base_height_(base_height),
      kind_(kind),
      num_slots_(kind == SumKind::kMeanOnly ? kNumMeanSlots : kNumSlots),
      stride_(cells.width + 2 * kRing),
      sums_(static_cast<size_t>(stride_) * (cells.height + 2 * kRing) * num_slots_, 0.0) {}

double* WeightedSums::Slot(int row, int col) {
  return sums_.data() + (static_cast<ptrdiff_t>(row + kRing) * stride_ + col + kRing) * num_slots_;
}

CellSums WeightedSums::At(int row, int col) const {
  const double* slots =
      sums_.data() + (static_cast<ptrdiff_t>(row + kRing) * stride_ + col + kRing) * num_slots_;
  if (kind_ == SumKind::kMeanOnly) return {.weight = slots[0], .height = slots[1]};
  return {slots[0], slots[1], slots[2], slots[3], slots[4]};
}

// A radius of at most one cell reaches four centres.
void WeightedSums::AddNear(const DensePoint* points, size_t num_points) {
  static const Weigher kWeigh = FastestWeigher();
  const double to_centres = (0.5 - kRing) * cell_size_;
  const Layout layout{.west = west_ + to_centres,
                      .north = north_ - to_centres,
                      .per_cell = 1.0 / cell_size_,
                      .base_height = base_height_,
                      .num_cols = static_cast<double>(cells_.width + kRing),
                      .num_rows = static_cast<double>(cells_.height + kRing),
                      .cell_area = cell_size_ * cell_size_,
                      .squared_radius = radius_ * radius_,
                      .stride = stride_};
  Batch batch;
  for (size_t first = 0; first < num_points; first += kBatch) {
    const size_t count = std::min(kBatch, num_points - first);
    kWeigh(points + first, count, layout, batch);
    if (kind_ == SumKind::kMeanOnly) {
      ScatterMean(batch, count, stride_, sums_.data());
    } else {
      ScatterAll(batch, count, stride_, sums_.data());
    }
    for (size_t i = 0; i < count; ++i) {
      if (batch.is_on_line[i] != 0) AddWide(points[first + i]);
    }
  }
}

void WeightedSums::AddWide(const DensePoint& point) {
  const double reach = radius_ / cell_size_;
  const double u = (point.point_in_world.x() - west_) / cell_size_ - 0.5;
  const double v = (north_ - point.point_in_world.y()) / cell_size_ - 0.5;
  const bool is_near = std::isfinite(point.point_in_world.z()) && u >= -reach - 1.0 &&
                       v >= -reach - 1.0 && u <= cells_.width + reach && v <= cells_.height + reach;
  if (!is_near) return;
  const int west = std::max(0, static_cast<int>(std::ceil(u - reach)));
  const int east = std::min(cells_.width - 1, static_cast<int>(std::floor(u + reach)));
  const int north = std::max(0, static_cast<int>(std::ceil(v - reach)));
  const int south = std::min(cells_.height - 1, static_cast<int>(std::floor(v + reach)));
  const double height = point.point_in_world.z() - base_height_;
  for (int row = north; row <= south; ++row) {
    for (int col = west; col <= east; ++col) {
      const double squared =
          ((u - col) * (u - col) + (v - row) * (v - row)) * cell_size_ * cell_size_;
      if (squared > radius_ * radius_) continue;
      const double weight = 1.0 / std::max(squared, kExactHitM * kExactHitM);
      double* slots = Slot(row, col);
      slots[0] += weight;
      slots[1] += weight * height;
      if (kind_ == SumKind::kMeanOnly) continue;
      slots[2] += weight * height * height;
      slots[3] += 1.0;
      slots[4] += static_cast<double>(point.height_sd_m) * static_cast<double>(point.height_sd_m);
    }
  }
}

void WeightedSums::Add(const DensePoint* points, size_t num_points) {
  if (radius_ <= cell_size_) {
    AddNear(points, num_points);
    return;
  }
  for (size_t i = 0; i < num_points; ++i) AddWide(points[i]);
}

}  // namespace freelsd
