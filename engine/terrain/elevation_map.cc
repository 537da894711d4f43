#include <cmath>
#include <limits>

#include <opencv2/imgproc.hpp>

#include "engine/check/check.h"
#include "engine/terrain/cell_fusion.h"
#include "engine/terrain/pair_summary.h"
#include "engine/terrain/terrain.h"
#include "engine/terrain/weighted_sums.h"

namespace freelsd {
namespace {

// Most cells that a point may reach to each side. More only blurs, and the cost is quadratic.
constexpr double kMaxReachCells = 20.0;

void CheckGrid(const Grid& grid, const TerrainOptions& options) {
  const FieldCheck check("terrain");
  check.Require(std::isfinite(grid.cell_size_m) && grid.cell_size_m > 0.0,
                "grid.cell_size_m",
                grid.cell_size_m,
                "must be positive");
  check.Require(grid.num_rows >= 0, "grid.num_rows", grid.num_rows, "must not be negative");
  check.Require(grid.num_cols >= 0, "grid.num_cols", grid.num_cols, "must not be negative");
  const double num_cells = static_cast<double>(grid.num_rows) * grid.num_cols;
  const std::string limit =
      "must not exceed max_num_cells = " + std::to_string(options.max_num_cells);
  check.Require(num_cells <= options.max_num_cells, "grid.num_cells", num_cells, limit);
  check.Require(options.interpolation_radius_m <= kMaxReachCells * grid.cell_size_m,
                "interpolation_radius_m",
                options.interpolation_radius_m,
                "must not exceed 20 cells");
}

cv::Mat1f Unknown(const Grid& grid) {
  return cv::Mat1f(grid.num_rows, grid.num_cols, std::numeric_limits<float>::quiet_NaN());
}

void Write(const FusedCell& cell, int row, int col, ElevationMap& map) {
  map.elevation(row, col) = static_cast<float>(cell.elevation);
  map.upper(row, col) = std::max(static_cast<float>(cell.upper), map.elevation(row, col));
  map.standard_deviation(row, col) = static_cast<float>(cell.standard_deviation);
  map.num_points(row, col) = static_cast<float>(cell.num_points);
}

// Share of the step down to the lowest ground nearby in the deviation of a cell. Three deviations
// cover the step.
constexpr float kStepShare = 0.4f;

// Matching and interpolation spread the height of what stands up over the ground beside it. Where a
// cell stands higher than ground within reach of its points, it may truly be as low.
void WidenAtSteps(const TerrainOptions& options, ElevationMap& map) {
  const int reach = static_cast<int>(
      std::max(1.0, std::round(options.interpolation_radius_m / map.grid.cell_size_m)));
  cv::Mat1f lowest = map.elevation.clone();
  lowest.setTo(std::numeric_limits<float>::infinity(), ~cv::Mat1b(lowest == lowest));
  cv::erode(lowest, lowest, cv::Mat1b::ones(2 * reach + 1, 2 * reach + 1));
  for (int row = 0; row < map.grid.num_rows; ++row) {
    for (int col = 0; col < map.grid.num_cols; ++col) {
      const float step = map.elevation(row, col) - lowest(row, col);
      // NaN is not a step.
      if (!(step > options.max_pair_disagreement_m)) continue;
      float& deviation = map.standard_deviation(row, col);
      deviation = std::hypot(deviation, kStepShare * step);
    }
  }
}

std::optional<WeightedSums> WithPoints(std::optional<WeightedSums> sums,
                                       const Points& points,
                                       const Grid& grid,
                                       const TerrainOptions& options) {
  if (points.empty()) return sums;
  if (!sums) {
    sums.emplace(grid,
                 cv::Rect(0, 0, grid.num_cols, grid.num_rows),
                 options.interpolation_radius_m,
                 points.front().point_in_world.z(),
                 SumKind::kMeanOnly);
  }
  sums->Add(points.data(), points.size());
  return sums;
}

ElevationMap MapOfMeans(const WeightedSums& sums, const Grid& grid) {
  ElevationMap map{grid, Unknown(grid), {}, Unknown(grid), Unknown(grid)};
  for (int row = 0; row < grid.num_rows; ++row) {
    for (int col = 0; col < grid.num_cols; ++col) {
      const CellSums sum = sums.At(row, col);
      if (sum.weight == 0.0) continue;
      map.elevation(row, col) = static_cast<float>(sums.base_height() + sum.height / sum.weight);
      map.standard_deviation(row, col) = 0.0f;
      map.num_points(row, col) = 1.0f;
    }
  }
  map.upper = map.elevation.clone();
  return map;
}

}  // namespace

void TerrainOptions::Check() const {
  const FieldCheck check("terrain");
  check.Inside("cell_size_m", cell_size_m, 0.05, 100.0);
  check.Inside("interpolation_radius_m", interpolation_radius_m, 0.01, 1000.0);
  check.Inside("min_num_points", min_num_points, 1, 1000000);
  check.Inside("outlier_sigma", outlier_sigma, 1.0, 1e6);
  check.Inside("max_pair_disagreement_m", max_pair_disagreement_m, 0.01, 100.0);
  check.Inside("pair_agreement_sigma", pair_agreement_sigma, 0.0, 100.0);
  check.Inside("unchecked_factor", unchecked_factor, 1.0, 100.0);
  check.Inside("upper_percentile", upper_percentile, 50.0, 100.0);
  check.Inside("max_relief_m", max_relief_m, 1.0, 10000.0);
  check.Inside("max_num_cells", max_num_cells, 1, 25000000);
}

bool ElevationMap::IsSeen(int row, int col) const { return std::isfinite(elevation(row, col)); }

struct ElevationMapBuilder::State {
  Grid grid;
  TerrainOptions options;
  PairSummarizer summarizer;
  // One list per pair, in row-major order.
  std::vector<std::vector<CellSummary>> pairs;
  // Sums of all points so far, for the paper's mean only.
  std::optional<WeightedSums> sums;
};

ElevationMapBuilder::ElevationMapBuilder(const Grid& grid, const TerrainOptions& options) {
  options.Check();
  CheckGrid(grid, options);
  state_ = std::make_unique<State>(State{grid, options, {grid, options}, {}, {}});
}

ElevationMapBuilder::~ElevationMapBuilder() = default;

void ElevationMapBuilder::Add(const Points& points) {
  if (state_->options.height_fusion == HeightFusion::kPaperMean) {
    state_->sums = WithPoints(std::move(state_->sums), points, state_->grid, state_->options);
    return;
  }
  std::vector<CellSummary> summaries = state_->summarizer.Summarize(points);
  summaries.shrink_to_fit();
  if (!summaries.empty()) state_->pairs.push_back(std::move(summaries));
}

ElevationMap ElevationMapBuilder::Build() const {
  const Grid& grid = state_->grid;
  if (state_->sums) return MapOfMeans(*state_->sums, grid);
  ElevationMap map{grid, Unknown(grid), Unknown(grid), Unknown(grid), Unknown(grid)};
  // Row by row, so that only one row's summaries are in memory.
  std::vector<size_t> next(state_->pairs.size(), 0);
  std::vector<std::vector<CellSummary>> of_col(grid.num_cols);
  for (int row = 0; row < grid.num_rows; ++row) {
    for (std::vector<CellSummary>& summaries : of_col) summaries.clear();
    const uint64_t end = (static_cast<uint64_t>(row) + 1) * grid.num_cols;
    for (size_t i = 0; i < next.size(); ++i) {
      const std::vector<CellSummary>& pair = state_->pairs[i];
      for (; next[i] < pair.size() && pair[next[i]].cell < end; ++next[i]) {
        of_col[pair[next[i]].cell % grid.num_cols].push_back(pair[next[i]]);
      }
    }
    for (int col = 0; col < grid.num_cols; ++col) {
      const std::optional<FusedCell> cell = FuseCell(of_col[col], state_->options);
      if (cell) Write(*cell, row, col, map);
    }
  }
  if (!map.elevation.empty()) WidenAtSteps(state_->options, map);
  return map;
}

}  // namespace freelsd
