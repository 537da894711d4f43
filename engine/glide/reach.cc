#include "engine/glide/reach.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <opencv2/imgproc.hpp>

#include "engine/glide/glide.h"
#include "engine/glide/height_pyramid.h"
#include "engine/glide/node_mask.h"
#include "engine/glide/outline.h"
#include "engine/glide/reach_fan.h"
#include "engine/glide/transit.h"

namespace freelsd {
namespace {

// Greatest width of a sector, in cells. The pyramid allows one cell to each side of the middle.
constexpr double kSectorWidthCells = 1.8;
constexpr int kMinNumSectors = 360;
// FanTask::overlap_m, in cells of the ground.
constexpr double kOverlapCells = 3.0;
// Around each cell, the highest of so many cells counts. Joined cells need more: then all that a
// line of the finer search meets lies within, as its place differs by up to a joined cell.
constexpr int kMarginCells = 1;
constexpr int kMarginOfJoined = 2;
// Cells are joined only where as many are in a row and in a column.
constexpr int kMinNumJoined = 128;
// Of ReachLimits::max_work, for each cell and each wind and heading.
constexpr double kStepsPerCell = 0.03;

// What is reckoned with: `start` is as low as the turn between two headings leaves it.
struct Glider {
  GlideStart start;
  std::vector<Eigen::Vector2d> winds;
  std::vector<double> headings;
  Performance performance;
  // Height of the start above the lowest ground.
  double above_lowest = 0.0;
};

// What all fans share.
struct Search {
  const ReachGround& ground;
  const ReachLimits& limits;
  HeightPyramid pyramid;
  double overlap_m = 0.0;
  // Straight flight down to the lowest ground, metres in the frame of the air.
  double max_straight_m = 0.0;
  int num_sectors = kMinNumSectors;
};

double LowestTop(const ReachGround& ground) {
  double lowest = 0.0;
  cv::minMaxLoc(ground.top, &lowest);
  return lowest;
}

// `cells_per_side`: of the cells of `ground`, as Reach has it.
Search SearchOver(const ReachGround& ground,
                  int cells_per_side,
                  const ReachLimits& limits,
                  const Glider& glider) {
  const Performance& performance = glider.performance;
  Search search{ground,
                limits,
                HeightPyramid(ground.top, cells_per_side > 1 ? kMarginOfJoined : kMarginCells),
                kOverlapCells * ground.grid.cell_size_m / cells_per_side};
  const double above_m = std::max(0.0, glider.above_lowest - limits.terrain_clearance_m);
  search.max_straight_m =
      above_m * performance.straight.airspeed_mps / performance.straight.sink_rate_mps;
  const double around_m = 2.0 * kPi * (search.max_straight_m + 2.0 * performance.turn_radius);
  search.num_sectors =
      std::max(kMinNumSectors,
               static_cast<int>(around_m / (kSectorWidthCells * ground.grid.cell_size_m)) + 1);
  return search;
}

// In steps: what it takes to trace the lines, and to draw the fan.
double WorkOf(const Fan& fan, const Grid& grid) {
  return static_cast<double>(fan.num_steps) +
         kStepsPerCell * static_cast<double>(grid.num_rows) * grid.num_cols;
}

// Cells that lie in the fans of all winds and headings, as a whole. Nothing if the search foresees
// too much work.
std::optional<cv::Mat1b> CellsInReach(const Glider& glider, const Search& search) {
  const Grid& grid = search.ground.grid;
  const auto num_fans = static_cast<double>(glider.winds.size() * glider.headings.size());
  const bool can_join = std::min(grid.num_rows, grid.num_cols) >= kMinNumJoined;
  NodeMask common(grid.num_rows, grid.num_cols);
  NodeMask mask(grid.num_rows, grid.num_cols);
  bool is_first = true;
  for (const Eigen::Vector2d& wind : glider.winds) {
    for (const double heading : glider.headings) {
      const FanTask task{glider.start.position_in_world,
                         AirHeading(heading, wind, glider.performance.Airspeed()),
                         wind,
                         glider.performance,
                         search.num_sectors,
                         search.max_straight_m,
                         search.overlap_m};
      search.limits.before_fan();
      const Fan fan = FanOf(task, grid, search.pyramid, search.limits);
      if (is_first && can_join && num_fans * WorkOf(fan, grid) > search.limits.max_work) {
        return std::nullopt;
      }
      NodeMask& filled = is_first ? common : mask;
      if (!is_first) mask.Clear();
      for (const FanPolygon& polygon : fan.polygons) filled.Fill(polygon);
      if (!is_first) common.Intersect(mask);
      is_first = false;
    }
  }
  return common.WholeCells();
}

// Cells of twice the size, set where all four are.
cv::Mat1b Halved(const cv::Mat1b& cells) {
  cv::Mat1b halved(cells.rows / 2, cells.cols / 2);
  for (int row = 0; row < halved.rows; ++row) {
    const uchar* const upper = cells.ptr(2 * row);
    const uchar* const lower = cells.ptr(2 * row + 1);
    for (int col = 0; col < halved.cols; ++col) {
      halved(row, col) = static_cast<uchar>(upper[2 * col] & upper[2 * col + 1] & lower[2 * col] &
                                            lower[2 * col + 1]);
    }
  }
  return halved;
}

// Cells of twice the size. What is left over at the southern and eastern edge is left out.
ReachGround Joined(const ReachGround& ground) {
  ReachGround joined{ground.grid, {}, {}};
  joined.grid.cell_size_m *= 2.0;
  joined.grid.num_rows /= 2;
  joined.grid.num_cols /= 2;
  joined.top = cv::Mat1f(joined.grid.num_rows, joined.grid.num_cols);
  for (int row = 0; row < joined.top.rows; ++row) {
    const float* const upper = ground.top.ptr<float>(2 * row);
    const float* const lower = ground.top.ptr<float>(2 * row + 1);
    for (int col = 0; col < joined.top.cols; ++col) {
      joined.top(row, col) =
          std::max({upper[2 * col], upper[2 * col + 1], lower[2 * col], lower[2 * col + 1]});
    }
  }
  joined.is_known = Halved(ground.is_known);
  return joined;
}

// The part of a grid in which the aircraft turns.
cv::Rect TurningPart(const Glider& glider, const Grid& grid) {
  double drift_ratio = 0.0;
  for (const Eigen::Vector2d& wind : glider.winds) {
    drift_ratio = std::max(drift_ratio, wind.norm() / glider.performance.Airspeed());
  }
  const double reach_m = (4.0 + 2.0 * kPi * drift_ratio) * glider.performance.turn_radius;
  return grid.CellsAround({glider.start.position_in_world.head<2>()}, reach_m) &
         cv::Rect(0, 0, grid.num_cols, grid.num_rows);
}

// A part of the joined cells: those of which the search over the ground's own cells sets all.
cv::Mat1b WhollyInReach(const cv::Rect& part,
                        int cells_per_side,
                        const Glider& glider,
                        const ReachGround& ground,
                        const ReachLimits& limits) {
  const cv::Rect cells(part.tl() * cells_per_side, part.size() * cells_per_side);
  const ReachGround below{
      ground.grid.Part(cells), ground.top(cells).clone(), ground.is_known(cells).clone()};
  ReachLimits unlimited = limits;
  unlimited.max_work = std::numeric_limits<double>::infinity();
  cv::Mat1b whole = *CellsInReach(glider, SearchOver(below, 1, unlimited, glider));
  for (int side = 1; side < cells_per_side; side *= 2) whole = Halved(whole);
  return whole;
}

// Of the joined cells in reach, those that the search over the ground's own cells surely finds.
// Where the aircraft turns, this takes that search, because turns are narrower than joined cells.
// Elsewhere it draws its edges at most a joined cell further in.
cv::Mat1b InnerBound(cv::Mat1b cells,
                     int cells_per_side,
                     const Glider& glider,
                     const ReachGround& ground,
                     const ReachLimits& limits) {
  Grid grid = ground.grid;
  grid.cell_size_m *= cells_per_side;
  grid.num_rows = cells.rows;
  grid.num_cols = cells.cols;
  const cv::Rect part = TurningPart(glider, grid);
  if (!part.empty()) {
    cells(part) &= WhollyInReach(part, cells_per_side, glider, ground, limits);
  }
  cv::Mat1b inner;
  const cv::Mat1b neighbours(3, 3, uchar{1});
  cv::erode(cells, inner, neighbours, {-1, -1}, 1, cv::BORDER_CONSTANT, cv::Scalar(0));
  return inner;
}

size_t NumVertices(const std::vector<ReachArea>& areas) {
  size_t count = 0;
  for (const ReachArea& area : areas) {
    count += area.outer.size();
    for (const Polygon& hole : area.holes) count += hole.size();
  }
  return count;
}

Reach OutlinesOf(cv::Mat1b known, cv::Mat1b unknown, Grid grid, const ReachLimits& limits) {
  while (true) {
    Reach reach{OutlinesOf(known.clone(), grid), OutlinesOf(unknown.clone(), grid)};
    const size_t count = NumVertices(reach.known) + NumVertices(reach.unknown);
    if (count <= static_cast<size_t>(std::max(0, limits.max_num_vertices))) return reach;
    if (known.rows < 2 || known.cols < 2) return {};
    known = Halved(known);
    unknown = Halved(unknown);
    grid.cell_size_m *= 2.0;
  }
}

}  // namespace

Reach ReachOf(const GlideStart& start,
              const ReachGround& ground,
              const Aircraft& aircraft,
              const GlideOptions& options,
              const ReachLimits& limits) {
  const Performance performance = PerformanceOf(aircraft);
  const std::vector<Eigen::Vector2d> winds = WindsToReckonWith(start, aircraft, options);
  for (const Eigen::Vector2d& wind : winds) {
    if (wind.norm() >= performance.Airspeed()) return {};
  }
  Glider glider{start, winds, HeadingsToReckonWith(start, options), performance};
  double& height = glider.start.position_in_world.z();
  height -= TimeBetweenHeadings(start, performance, options) * performance.turning_sink_rate;
  glider.above_lowest = height - LowestTop(ground);
  ReachGround searched = ground;
  for (int cells_per_side = 1;; cells_per_side *= 2, searched = Joined(searched)) {
    const auto found = CellsInReach(glider, SearchOver(searched, cells_per_side, limits, glider));
    if (!found) continue;
    const cv::Mat1b cells =
        cells_per_side == 1 ? *found : InnerBound(*found, cells_per_side, glider, ground, limits);
    const cv::Mat1b known = cells & searched.is_known, unknown = cells & ~searched.is_known;
    Reach reach = OutlinesOf(known, unknown, searched.grid, limits);
    reach.cells_per_side = cells_per_side;
    return reach;
  }
}

double GreatestGlideDistance(const GlideStart& start,
                             double height_m,
                             const Aircraft& aircraft,
                             const GlideOptions& options) {
  const StraightGlide glide = StraightGlideOf(aircraft);
  const double wind = start.wind_in_world ? start.wind_in_world->norm() : options.unknown_wind_mps;
  return std::max(0.0, height_m) / glide.sink_rate_mps * (glide.airspeed_mps + wind);
}

}  // namespace freelsd
