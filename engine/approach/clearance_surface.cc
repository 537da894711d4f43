#include "engine/approach/clearance_surface.h"

#include <algorithm>
#include <utility>

#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

// Largest number of steps of a circle. On larger circles the steps, and the corridor, grow.
constexpr double kMaxNumCircleSteps = 20000.0;
// A disc is dilated in passes of at most this radius, because the cost grows with its area.
constexpr double kMaxPassRadiusCells = 7.0;
// Keeps the tangent finite. With a larger assumed tilt, no path is clear in any case.
constexpr double kMaxLeanDeg = 80.0;

double LargestRadius(const std::vector<WindScenario>& scenarios) {
  double radius = 0.0;
  for (const WindScenario& scenario : scenarios) radius = std::max(radius, scenario.loiter_radius);
  return radius;
}

// Distance from a touchdown to the far side of a circle.
double Reach(const std::vector<WindScenario>& scenarios) {
  double reach = 0.0;
  for (const WindScenario& scenario : scenarios) {
    reach = std::max(reach, std::max(scenario.approach_distance, 0.0) + 2 * scenario.loiter_radius);
  }
  return reach;
}

struct CellHeight {
  float height = kNoHeight;
  bool is_unseen = true;
};

// 1 for cells of `cells` around which all cells within the radius are seen and even, else 0. Under
// branches, also leafless ones, the ground is not even.
cv::Mat1b BareGround(const ElevationMap& map,
                     const HazardLayers& hazards,
                     const ApproachOptions& options,
                     const cv::Rect& cells) {
  const int half = static_cast<int>(std::ceil(options.bare_ground_radius_m / map.grid.cell_size_m));
  cv::Mat1b is_even(cells.size());
  for (int row = 0; row < cells.height; ++row) {
    for (int col = 0; col < cells.width; ++col) {
      const cv::Point cell = cv::Point(col, row) + cells.tl();
      // NaN is not even.
      is_even(row, col) = hazards.roughness(cell) <= options.max_bare_roughness_m &&
                          map.upper(cell) - map.elevation(cell) <= options.max_bare_roughness_m &&
                          map.standard_deviation(cell) <= options.max_height_sd_m;
    }
  }
  cv::Mat1b is_bare;
  cv::erode(is_even,
            is_bare,
            cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * half + 1, 2 * half + 1}),
            cv::Point(-1, -1),
            1,
            cv::BORDER_CONSTANT,
            cv::Scalar::all(0.0));
  return is_bare;
}

CellHeight HeightOf(const ElevationMap& map,
                    const HazardLayers& hazards,
                    const ApproachOptions& options,
                    const cv::Point& cell,
                    bool is_bare) {
  const float elevation = map.elevation(cell), upper = map.upper(cell);
  const float top = std::isnan(upper) ? elevation : upper;
  const float sd = map.standard_deviation(cell);
  const bool is_certain = sd <= options.max_height_sd_m;  // an unknown deviation is not
  if (std::isnan(top)) return {};
  // After a comparison of photographs, every remaining height is reliable.
  const bool is_clear_class =
      map.is_compared || is_bare || hazards.grass(cell) >= hazards.min_clear_class_posterior;
  const double allowance = is_clear_class ? 0.0 : options.unclear_height_allowance_m;
  return {.height = top + static_cast<float>(allowance),
          .is_unseen = std::isnan(elevation) || std::isnan(upper) || !is_certain};
}

// Maximum over the disc around each cell; cells outside have the value `outside`.
cv::Mat MaxOverDisc(const cv::Mat& raster, double radius_cells, double outside) {
  const double num_passes = std::ceil(radius_cells / kMaxPassRadiusCells);
  // A disc of whole cells is smaller than its radius. With two or more passes, this error
  // accumulates.
  const double pass_radius = radius_cells / num_passes + (num_passes > 1.0 ? std::sqrt(0.5) : 0.0);
  const int half = static_cast<int>(std::floor(pass_radius));
  cv::Mat1b disc(2 * half + 1, 2 * half + 1, uchar{0});
  for (int row = -half; row <= half; ++row) {
    for (int col = -half; col <= half; ++col) {
      disc(row + half, col + half) = row * row + col * col <= pass_radius * pass_radius;
    }
  }
  cv::Mat widened;
  cv::dilate(raster,
             widened,
             disc,
             cv::Point(-1, -1),
             static_cast<int>(num_passes),
             cv::BORDER_CONSTANT,
             cv::Scalar::all(outside));
  return widened;
}

ClearanceSurface WithStep(double circle_step,
                          const ElevationMap& map,
                          const Aircraft& aircraft,
                          const ApproachOptions& options) {
  ClearanceSurface surface;
  surface.cell_size = map.grid.cell_size_m;
  surface.circle_step = circle_step;
  // Up to three half diagonals: from the cell's centre to the place in it, from the corridor's edge
  // to the farthest sample beyond it, and from there to that cell's centre.
  surface.corridor_radius =
      aircraft.path_half_width_m + 3.0 * surface.HalfDiagonal() + 0.5 * surface.circle_step;
  surface.lean = std::tan(RadFromDeg(std::min(options.tilt_sigma * map.tilt_sd_deg, kMaxLeanDeg)));
  return surface;
}

ClearanceSurface WithHeights(ClearanceSurface surface,
                             const ElevationMap& map,
                             const HazardLayers& hazards,
                             const cv::Rect& cells,
                             const ApproachOptions& options) {
  surface.first_row = cells.y;
  surface.first_col = cells.x;
  surface.north_west_in_world =
      map.grid.north_west_in_world + map.grid.cell_size_m * Eigen::Vector2d(cells.x, -cells.y);
  surface.height = cv::Mat1f(cells.size(), kNoHeight);
  surface.is_unseen = cv::Mat1b(cells.size(), uchar{1});
  if (cells.empty()) return surface;
  surface.hazard = hazards.hazard(cells).clone();
  const cv::Mat1b is_bare = BareGround(map, hazards, options, cells);
  for (int row = 0; row < cells.height; ++row) {
    for (int col = 0; col < cells.width; ++col) {
      const cv::Point cell(col, row);
      const CellHeight known =
          HeightOf(map, hazards, options, cell + cells.tl(), is_bare(cell) != 0);
      surface.height(cell) = known.height;
      surface.is_unseen(cell) = known.is_unseen;
    }
  }
  return surface;
}

ClearanceSurface WithCorridors(ClearanceSurface surface) {
  if (surface.height.empty()) return surface;
  const double radius_cells = surface.corridor_radius / surface.cell_size;
  surface.corridor_height = MaxOverDisc(surface.height, radius_cells, kNoHeight);
  surface.corridor_is_unseen = MaxOverDisc(surface.is_unseen, radius_cells, 1.0);
  return surface;
}

}  // namespace

double CircleStep(const std::vector<WindScenario>& scenarios, const ApproachOptions& options) {
  return std::max(options.path_step_m, 2.0 * kPi * LargestRadius(scenarios) / kMaxNumCircleSteps);
}

ClearanceSurface MakeClearanceSurface(const ElevationMap& map,
                                      const HazardLayers& hazards,
                                      const Polygon& footprint,
                                      const std::vector<WindScenario>& scenarios,
                                      const Aircraft& aircraft,
                                      const ApproachOptions& options) {
  ClearanceSurface surface = WithStep(CircleStep(scenarios, options), map, aircraft, options);
  const cv::Rect cells =
      map.grid.CellsAround(footprint, Reach(scenarios) + surface.corridor_radius);
  return WithCorridors(WithHeights(std::move(surface), map, hazards, cells, options));
}

ClearanceSurface MakeClearanceSurfaceOfMap(const ElevationMap& map,
                                           const HazardLayers& hazards,
                                           const Aircraft& aircraft,
                                           const ApproachOptions& options) {
  return WithCorridors(MakeHeightSurface(
      map, hazards, {0, 0, map.grid.num_cols, map.grid.num_rows}, aircraft, options));
}

ClearanceSurface MakeHeightSurface(const ElevationMap& map,
                                   const HazardLayers& hazards,
                                   const cv::Rect& cells,
                                   const Aircraft& aircraft,
                                   const ApproachOptions& options) {
  return WithHeights(
      WithStep(options.path_step_m, map, aircraft, options), map, hazards, cells, options);
}

}  // namespace freelsd
