#include "engine/terrain/weighted_sums.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/terrain/registers.h"

namespace freelsd {
namespace {

constexpr int kRing = 1;
// Slots of a cell: weight and height, or weight, height, squared height and an unused one.
// Distances and weights are in cells until At() returns them.
constexpr int kNumMeanSlots = 2;
constexpr int kNumSlots = 4;
// Points per batch; one batch fits into the first-level cache.
constexpr size_t kBatch = 256;

constexpr size_t kMaxSumLanes = 4;

double Squared(double value) { return value * value; }

// Position of points among the cells, in cells from the ring's corner.
struct Layout {
  double west, north, per_cell, base_height;
  double num_cols, num_rows;
  // In cells.
  double least_squared, squared_radius;
  int stride;
};

// The cell centre north-west of the point, and the weights for this cell and its neighbours to the
// east, south and south-east.
struct Batch {
  alignas(kMaxSumLanes * sizeof(double)) std::array<std::array<double, kBatch>, 4> weights;
  // 1 where the weight is above 0.
  alignas(kMaxSumLanes * sizeof(double)) std::array<std::array<double, kBatch>, 4> counts;
  alignas(kMaxSumLanes * sizeof(double)) std::array<double, kBatch> height;
  alignas(kMaxSumLanes * sizeof(double)) std::array<double, kBatch> variance;
  alignas(kMaxSumLanes * sizeof(double)) std::array<int, kBatch> slot;
  // Unweighted: a point on a line of centres may lie a whole radius from centres on both sides.
  alignas(kMaxSumLanes * sizeof(double)) std::array<int64_t, kBatch> is_on_line;
};

template <size_t num_lanes, SumKind kind>
[[gnu::always_inline]] inline void WeighLanes(const DensePoint* points,
                                              const Layout& layout,
                                              size_t i,
                                              Batch& batch) {
  using Doubles = typename Register<num_lanes>::Doubles;
  using Ints = typename Register<num_lanes>::Ints;
  Doubles x, y, z;
  for (size_t lane = 0; lane < num_lanes; ++lane) {
    x[lane] = points[lane].point_in_world[0];
    y[lane] = points[lane].point_in_world[1];
    z[lane] = points[lane].point_in_world[2];
  }
  const Doubles zero{}, least = zero + layout.least_squared;
  const Doubles u = (x - layout.west) * layout.per_cell;
  const Doubles v = (layout.north - y) * layout.per_cell;
  const Doubles height = z - layout.base_height;
  const auto is_inside = (u >= 0.0) & (v >= 0.0) & (u < layout.num_cols) & (v < layout.num_rows) &
                         (height - height == 0.0);  // neither infinite nor NaN
  const Doubles u_in = is_inside ? u : zero, v_in = is_inside ? v : zero;
  Ints col, row;
  Convert(u_in, col);
  Convert(v_in, row);
  Doubles col_center, row_center;
  Convert(col, col_center);
  Convert(row, row_center);
  const Doubles west = u_in - col_center, east = west - 1.0;
  const Doubles north = v_in - row_center, south = north - 1.0;
  const Doubles ww = west * west, ee = east * east, nn = north * north, ss = south * south;
  Doubles a = ww + nn, b = ee + nn, c = ww + ss, d = ee + ss;
  a = least > a ? least : a;
  b = least > b ? least : b;
  c = least > c ? least : c;
  d = least > d ? least : d;
  // Four reciprocals from one division: 1 / a = (b c d) / (a b c d), because division is slow.
  const Doubles ab = a * b, cd = c * d, quotient = 1.0 / (ab * cd);
  const auto is_on_line = is_inside & ((west == 0.0) | (north == 0.0));
  const Doubles reciprocal = is_inside & ~is_on_line ? quotient : zero;
  const Doubles weights[] = {a <= layout.squared_radius ? reciprocal * (b * cd) : zero,
                             b <= layout.squared_radius ? reciprocal * (a * cd) : zero,
                             c <= layout.squared_radius ? reciprocal * (ab * d) : zero,
                             d <= layout.squared_radius ? reciprocal * (ab * c) : zero};
  for (size_t k = 0; k < 4; ++k) Store(weights[k], &batch.weights[k][i]);
  Store(is_inside ? height : zero, &batch.height[i]);
  Store(row * layout.stride + col, &batch.slot[i]);
  Store(is_on_line, &batch.is_on_line[i]);
  if constexpr (kind == SumKind::kAll) {
    Doubles deviation;
    for (size_t lane = 0; lane < num_lanes; ++lane) deviation[lane] = points[lane].height_sd_m;
    Store(deviation * deviation, &batch.variance[i]);
    const Doubles one = zero + 1.0;
    for (size_t k = 0; k < 4; ++k) Store(weights[k] > 0.0 ? one : zero, &batch.counts[k][i]);
  }
}

template <size_t num_lanes, SumKind kind>
[[gnu::always_inline]] inline void Weigh(const DensePoint* points,
                                         size_t num_points,
                                         const Layout& layout,
                                         Batch& batch) {
  const size_t num_whole = num_points / num_lanes * num_lanes;
  for (size_t i = 0; i < num_whole; i += num_lanes) {
    WeighLanes<num_lanes, kind>(points + i, layout, i, batch);
  }
  if (num_whole == num_points) return;
  // Lanes behind the last point are not read.
  std::array<DensePoint, num_lanes> rest;
  std::copy(points + num_whole, points + num_points, rest.begin());
  WeighLanes<num_lanes, kind>(rest.data(), layout, num_whole, batch);
}

template <typename Lanes>
[[gnu::always_inline]] inline void AddTo(double* slots, const Lanes& terms) {
  Lanes sums;
  Load(slots, sums);
  sums += terms;
  Store(sums, slots);
}

// Sums of all cells, from the ring's corner.
struct Sums {
  double* slots;
  // Number of points and their variance.
  double* tallies;
};

using Two = Register<2>::Doubles;

[[gnu::always_inline]] inline void ScatterMean(const Batch& batch,
                                               size_t num_points,
                                               const ptrdiff_t corners[4],
                                               const Sums& sums) {
  for (size_t i = 0; i < num_points; ++i) {
    const Two term{1.0, batch.height[i]};
    double* slots = sums.slots + kNumMeanSlots * static_cast<ptrdiff_t>(batch.slot[i]);
    for (size_t k = 0; k < 4; ++k) {
      const double weight = batch.weights[k][i];
      AddTo(slots + kNumMeanSlots * corners[k], Two{weight, weight} * term);
    }
  }
}

template <size_t num_lanes>
[[gnu::always_inline]] inline void ScatterAll(const Batch& batch,
                                              size_t num_points,
                                              const ptrdiff_t corners[4],
                                              const Sums& sums) {
  using Four = Register<4>::Doubles;
  for (size_t i = 0; i < num_points; ++i) {
    const double height = batch.height[i], squared = height * height;
    const Two tally{1.0, batch.variance[i]};
    double* slots = sums.slots + kNumSlots * static_cast<ptrdiff_t>(batch.slot[i]);
    double* tallies = sums.tallies + 2 * static_cast<ptrdiff_t>(batch.slot[i]);
    for (size_t k = 0; k < 4; ++k) {
      const double weight = batch.weights[k][i], count = batch.counts[k][i];
      if constexpr (num_lanes == kNumSlots) {
        const Four weights{weight, weight, weight, weight}, term{1.0, height, squared, 0.0};
        AddTo(slots + kNumSlots * corners[k], weights * term);
      } else {
        const Two weights{weight, weight};
        AddTo(slots + kNumSlots * corners[k], weights * Two{1.0, height});
        AddTo(slots + kNumSlots * corners[k] + 2, weights * Two{squared, 0.0});
      }
      AddTo(tallies + 2 * corners[k], Two{count, count} * tally);
    }
  }
}

template <size_t num_lanes, SumKind kind>
[[gnu::always_inline]] inline void WeighAndScatter(const DensePoint* points,
                                                   size_t num_points,
                                                   const Layout& layout,
                                                   Batch& batch,
                                                   const Sums& sums) {
  Weigh<num_lanes, kind>(points, num_points, layout, batch);
  const ptrdiff_t corners[4] = {0, 1, layout.stride, layout.stride + 1};
  if constexpr (kind == SumKind::kMeanOnly) {
    ScatterMean(batch, num_points, corners, sums);
  } else {
    ScatterAll<num_lanes>(batch, num_points, corners, sums);
  }
}

using Adder = void (*)(const DensePoint*, size_t, const Layout&, Batch&, const Sums&);

template <SumKind kind>
void AddPlain(const DensePoint* points,
              size_t num_points,
              const Layout& layout,
              Batch& batch,
              const Sums& sums) {
  WeighAndScatter<2, kind>(points, num_points, layout, batch, sums);
}

#if defined(__x86_64__)
// No fused multiplications, so that every processor rounds alike.
template <SumKind kind>
[[gnu::target("avx2")]] void AddAvx2(const DensePoint* points,
                                     size_t num_points,
                                     const Layout& layout,
                                     Batch& batch,
                                     const Sums& sums) {
  WeighAndScatter<4, kind>(points, num_points, layout, batch, sums);
}

template <SumKind kind>
Adder FastestAdder() {
  return __builtin_cpu_supports("avx2") != 0 ? AddAvx2<kind> : AddPlain<kind>;
}
#else
template <SumKind kind>
Adder FastestAdder() {
  return AddPlain<kind>;
}
#endif

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
      sums_((static_cast<size_t>(stride_) * (cells.height + 2 * kRing) * num_slots_ + 3) / 4) {
  if (kind == SumKind::kAll) tallies_.assign(2 * sums_.size(), 0.0);
}

size_t WeightedSums::IndexOf(int row, int col) const {
  return static_cast<size_t>(row + kRing) * stride_ + col + kRing;
}

CellSums WeightedSums::At(int row, int col) const {
  const double* slots = Slots(IndexOf(row, col));
  const double per_area = 1.0 / Squared(cell_size_);
  CellSums sums{.weight = slots[0] * per_area, .height = slots[1] * per_area};
  if (kind_ == SumKind::kMeanOnly) return sums;
  sums.squared_height = slots[2] * per_area;
  sums.num_points = tallies_[2 * IndexOf(row, col)];
  sums.variance = tallies_[2 * IndexOf(row, col) + 1];
  return sums;
}

// A radius of at most one cell reaches at most four centres.
void WeightedSums::AddNear(const DensePoint* points, size_t num_points) {
  const Adder add = kind_ == SumKind::kMeanOnly ? FastestAdder<SumKind::kMeanOnly>()
                                                : FastestAdder<SumKind::kAll>();
  const double to_centres = (0.5 - kRing) * cell_size_;
  const Layout layout{.west = west_ + to_centres,
                      .north = north_ - to_centres,
                      .per_cell = 1.0 / cell_size_,
                      .base_height = base_height_,
                      .num_cols = static_cast<double>(cells_.width + kRing),
                      .num_rows = static_cast<double>(cells_.height + kRing),
                      .least_squared = Squared(kExactHitM / cell_size_),
                      .squared_radius = Squared(radius_ / cell_size_),
                      .stride = stride_};
  Batch batch;
  for (size_t first = 0; first < num_points; first += kBatch) {
    const size_t count = std::min(kBatch, num_points - first);
    add(points + first, count, layout, batch, {Slots(0), tallies_.data()});
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
      const double squared = Squared(u - col) + Squared(v - row);
      if (squared > Squared(reach)) continue;
      const double weight = 1.0 / std::max(squared, Squared(kExactHitM / cell_size_));
      double* slots = Slots(IndexOf(row, col));
      slots[0] += weight;
      slots[1] += weight * height;
      if (kind_ == SumKind::kMeanOnly) continue;
      slots[2] += weight * height * height;
      tallies_[2 * IndexOf(row, col)] += 1.0;
      tallies_[2 * IndexOf(row, col) + 1] += Squared(point.height_sd_m);
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
