#include "engine/next_look/known_ground.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <opencv2/imgproc.hpp>

#include "engine/footprint/footprint.h"

namespace freelsd {
namespace {

constexpr float kNone = -std::numeric_limits<float>::infinity();
// A refused cell that is less known than this is no sure hazard.
constexpr float kSurelyKnown = 0.5f;

// How well each cell of the map is known, and which of them are surely no landing ground.
struct MapKnowledge {
  cv::Mat1f known;
  cv::Mat1b is_refused;
};

// Is its kind the only thing that is wrong with a refused cell?
bool IsInDoubt(const LookRequest& request, const cv::Point& cell, double min_posterior) {
  const HazardLayers& layers = request.layers;
  const double grass = layers.grass(cell);
  return grass >= min_posterior && grass < layers.min_grass_posterior &&
         ShapeRatio(request.map, layers, request.aircraft, cell) <= 1.0;
}

float KnownShareOf(const LookRequest& request,
                   const cv::Point& cell,
                   const NextLookOptions& options) {
  const uint8_t hazard = request.layers.hazard(cell);
  if (hazard == kUnseen) return 0.0f;
  if (hazard == kFree) return 1.0f;
  const float share = std::min(
      1.0f,
      static_cast<float>(request.num_views(cell)) / static_cast<float>(options.num_views_to_know));
  const bool is_in_doubt = IsInDoubt(request, cell, options.min_doubtful_posterior);
  return is_in_doubt ? share * (1.0f - request.layers.grass(cell)) : share;
}

MapKnowledge MeasureKnowledge(const LookRequest& request, const NextLookOptions& options) {
  const cv::Size size = request.layers.hazard.size();
  MapKnowledge knowledge{cv::Mat1f(size, 0.0f), cv::Mat1b(size, uint8_t{0})};
  for (int row = 0; row < size.height; ++row) {
    for (int col = 0; col < size.width; ++col) {
      const cv::Point cell(col, row);
      const float known = KnownShareOf(request, cell, options);
      knowledge.known(cell) = known;
      knowledge.is_refused(cell) = request.layers.hazard(cell) == kHazard && known >= kSurelyKnown;
    }
  }
  return knowledge;
}

cv::Mat1f DistanceToRefused(const cv::Mat1b& is_refused, double cell_size_m) {
  cv::Mat1f distance(is_refused.size(), std::numeric_limits<float>::infinity());
  if (cv::countNonZero(is_refused) == 0) return distance;
  cv::distanceTransform(is_refused == 0, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  return distance * cell_size_m;
}

// Sums over the cells of the map that lie in each coarse cell.
struct CoarseSums {
  cv::Mat1f num_cells, known, free, seen, fits, low, height;
};

CoarseSums EmptySums(const cv::Size& size) {
  const auto zero = [&size] { return cv::Mat1f(size, 0.0f); };
  return {zero(), zero(), zero(), zero(), zero(), zero(), zero()};
}

// What a cell of the map adds to the coarse cell that it lies in.
struct CellOfMap {
  cv::Point cell, coarse;
  float known = 0.0f;
  bool is_refused = false;
  float clear_distance = 0.0f;
};

void AddCell(const LookRequest& request,
             const CellOfMap& of_map,
             CoarseSums& sums,
             KnownGround& ground) {
  const auto& [cell, coarse, known, is_refused, clear_distance] = of_map;
  sums.num_cells(coarse) += 1.0f;
  sums.known(coarse) += known;
  ground.clear_distance(coarse) = std::max(ground.clear_distance(coarse), clear_distance);
  if (request.layers.hazard(cell) == kUnseen) return;
  const float elevation = request.map.elevation(cell), top = request.map.upper(cell);
  // What stands lower than this leaves room for most of a path.
  const double low_height = 0.5 * request.aircraft.approach_height_m;
  sums.seen(coarse) += 1.0f;
  sums.fits(coarse) += clear_distance >= ground.disc_radius_m ? 1.0f : 0.0f;
  sums.low(coarse) += top - elevation < low_height ? 1.0f : 0.0f;
  sums.height(coarse) += elevation;
  ground.top(coarse) = std::max(ground.top(coarse), top);
  if (request.layers.hazard(cell) == kFree) sums.free(coarse) += 1.0f;
  if (!is_refused) return;
  ground.obstacle_top(coarse) = std::max(ground.obstacle_top(coarse), top);
}

// Mean of a quantity over the seen ground around each cell; of the whole map far from it.
cv::Mat1f Expected(const cv::Mat1f& sums, const cv::Mat1f& seen, double length_cells) {
  const double total = cv::sum(seen)[0];
  cv::Mat1f expected(sums.size(), 0.0f);
  if (total <= 0.0) return expected;
  const auto mean = static_cast<float>(cv::sum(sums)[0] / total);
  cv::Mat1f near_sums, near_seen, distance;
  const double sigma = 0.5 * length_cells;
  cv::GaussianBlur(sums, near_sums, {}, sigma, sigma, cv::BORDER_CONSTANT);
  cv::GaussianBlur(seen, near_seen, {}, sigma, sigma, cv::BORDER_CONSTANT);
  cv::distanceTransform(seen == 0.0f, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  constexpr float kHardlyAny = 1e-6f;
  for (int row = 0; row < expected.rows; ++row) {
    for (int col = 0; col < expected.cols; ++col) {
      const auto weight = static_cast<float>(std::exp(-distance(row, col) / length_cells));
      const bool has_near = near_seen(row, col) > kHardlyAny;
      const float near = has_near ? near_sums(row, col) / near_seen(row, col) : mean;
      expected(row, col) = weight * near + (1.0f - weight) * mean;
    }
  }
  return expected;
}

// The planner's least distance to hazard; without the map's margin if that is unknown.
double DiscRadiusOf(const LookRequest& request) {
  const double required = RequiredHazardDistance(request.map, request.aircraft, ApproachOptions{});
  return std::isfinite(required) ? required : request.aircraft.touchdown_uncertainty_m;
}

double CorridorHalfWidth(const LookRequest& request) {
  const ApproachOptions rules;
  const double sd_m = std::max(request.map.position_sd_m, rules.min_map_position_sd_m);
  const double margin_m = std::isfinite(sd_m) ? rules.path_margin_sigma * sd_m : 0.0;
  return request.aircraft.path_half_width_m + margin_m;
}

// Adds a photograph that shows some cells, whatever it tells about them.
void AddPhotograph(const LookRequest& request,
                   const Rigid3d& world_from_camera,
                   const HeightRange& heights,
                   KnownGround& ground) {
  const Footprint shown =
      FootprintOf(request.rig.camera, world_from_camera, heights.lowest_m, heights.highest_m);
  if (!shown.min_in_world.allFinite() || !shown.max_in_world.allFinite()) return;
  const Rigid3d camera_from_world = Inverse(world_from_camera);
  const cv::Rect cells =
      ground.grid.CellsAround({shown.min_in_world, shown.max_in_world}, ground.grid.cell_size_m);
  for (int row = cells.y; row < cells.y + cells.height; ++row) {
    for (int col = cells.x; col < cells.x + cells.width; ++col) {
      Eigen::Vector3d place;
      place << ground.grid.CellCenter(row, col), ground.height(row, col);
      const auto pixel = request.rig.camera.ImageFromCamera(camera_from_world * place);
      if (pixel && request.rig.camera.IsInside(*pixel)) ground.num_shown(row, col) += 1.0f;
    }
  }
}

KnownGround EmptyGround(const Grid& grid) {
  const cv::Size size(grid.num_cols, grid.num_rows);
  KnownGround ground;
  ground.grid = grid;
  ground.obstacle_top = cv::Mat1f(size, kNone);
  ground.top = cv::Mat1f(size, kNone);
  ground.clear_distance = cv::Mat1f(size, kNone);
  ground.num_shown = cv::Mat1f(size, 0.0f);
  return ground;
}

}  // namespace

KnownGround MeasureKnownGround(const LookRequest& request,
                               const Box& area,
                               const NextLookOptions& options) {
  const double cell_size_m = std::max(options.cell_size_m, request.map.grid.cell_size_m);
  const Grid grid = GridAround(area.min, area.max, cell_size_m);
  const MapKnowledge knowledge = MeasureKnowledge(request, options);
  const cv::Mat1f distance = DistanceToRefused(knowledge.is_refused, request.map.grid.cell_size_m);
  KnownGround ground = EmptyGround(grid);
  ground.disc_radius_m = DiscRadiusOf(request);
  ground.corridor_half_width_m = CorridorHalfWidth(request);
  CoarseSums sums = EmptySums(ground.top.size());
  for (int row = 0; row < distance.rows; ++row) {
    for (int col = 0; col < distance.cols; ++col) {
      const auto coarse = grid.CellAt(request.map.grid.CellCenter(row, col));
      if (!coarse) continue;
      const CellOfMap cell{{col, row},
                           *coarse,
                           knowledge.known(row, col),
                           knowledge.is_refused(row, col) != 0,
                           distance(row, col)};
      AddCell(request, cell, sums, ground);
    }
  }
  const double length_cells = options.prospect_length_m / cell_size_m;
  const double all_cells = std::pow(cell_size_m / request.map.grid.cell_size_m, 2.0);
  ground.known = sums.known / cv::max(sums.num_cells, all_cells);
  ground.free = sums.free / cv::max(sums.num_cells, all_cells);
  ground.fit_prospect = Expected(sums.fits, sums.seen, length_cells);
  ground.low_prospect = Expected(sums.low, sums.seen, length_cells);
  ground.height = Expected(sums.height, sums.seen, length_cells);
  cv::Mat1f(sums.height / sums.seen).copyTo(ground.height, sums.seen > 0.0f);
  ground.clear_distance.setTo(std::numeric_limits<float>::infinity(), sums.num_cells == 0.0f);
  const HeightRange heights = HeightRangeOf(ground.height);
  for (const Rigid3d& pose : request.flown) AddPhotograph(request, pose, heights, ground);
  return ground;
}

}  // namespace freelsd
