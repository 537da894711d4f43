#include "tests/evaluation/truth_run.h"

#include <limits>

#include "engine/hazard/distance_transform.h"

namespace freelsd {
namespace {

constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
// What adjusted blocks of the default flight say of themselves.
constexpr double kPositionDeviationM = 1.0;
constexpr float kHeightDeviationM = 0.1f;
constexpr float kNumPoints = 10.0f;

// Maps count rows from the north, the truth from the south.
cv::Point CellOfTruth(const TruthMap& truth, int row, int col) {
  return {col, truth.fault.rows - 1 - row};
}

ElevationMap TrueElevation(const Scenario& scenario, const TruthMap& truth) {
  ElevationMap map;
  const int n = truth.fault.rows;
  map.grid.num_rows = map.grid.num_cols = n;
  map.grid.cell_size_m = truth.cell_size_m;
  const Eigen::Vector2d half_cell(0.5 * truth.cell_size_m, -0.5 * truth.cell_size_m);
  map.grid.north_west_in_world = truth.CellCenter(n - 1, 0) - half_cell;
  map.position_sd_m = kPositionDeviationM;
  map.is_compared = true;
  map.elevation = cv::Mat1f(n, n, kUnknown);
  map.upper = map.elevation.clone();
  map.standard_deviation = map.elevation.clone();
  map.num_points = map.elevation.clone();
  for (int row = 0; row < n; ++row) {
    for (int col = 0; col < n; ++col) {
      const cv::Point cell = CellOfTruth(truth, row, col);
      if (!scenario.seen(cell)) continue;
      const Eigen::Vector2d place = map.grid.CellCenter(row, col);
      const float ground = static_cast<float>(scenario.world.GroundHeight(place.x(), place.y()));
      map.upper(row, col) = std::max(ground, truth.top(cell));
      // What is closed above has its top for elevation.
      const bool is_open = truth.cover(cell) == static_cast<uint8_t>(Cover::kBareTree);
      map.elevation(row, col) = is_open ? ground : map.upper(row, col);
      map.standard_deviation(row, col) = is_open ? kUnknown : kHeightDeviationM;
      map.num_points(row, col) = kNumPoints;
    }
  }
  return map;
}

HazardLayers TrueHazards(const ElevationMap& map, const TruthMap& truth) {
  HazardLayers layers;
  layers.grid = map.grid;
  const cv::Size size = map.elevation.size();
  layers.slope = cv::Mat1f::zeros(size);
  layers.roughness = cv::Mat1f::zeros(size);
  layers.grass = cv::Mat1f::zeros(size);
  layers.hazard = cv::Mat1b(size, uint8_t{kUnseen});
  for (int row = 0; row < size.height; ++row) {
    for (int col = 0; col < size.width; ++col) {
      if (!map.IsSeen(row, col)) continue;
      const bool is_free = truth.fault(CellOfTruth(truth, row, col)) == 0;
      layers.hazard(row, col) = is_free ? kFree : kHazard;
      layers.grass(row, col) = is_free ? 1.0f : 0.0f;
    }
  }
  layers.distance = DistanceToHazard(layers.hazard, map.grid.cell_size_m);
  return layers;
}

// Elsewhere no disc fits: another field in the same rectangle does not count.
HazardLayers WithinField(HazardLayers layers,
                         const Field& field,
                         const Fields& fields,
                         const TruthMap& truth) {
  layers.distance = layers.distance.clone();
  for (int row = 0; row < layers.distance.rows; ++row) {
    for (int col = 0; col < layers.distance.cols; ++col) {
      if (fields.label(CellOfTruth(truth, row, col)) != field.id) layers.distance(row, col) = 0.0f;
    }
  }
  return layers;
}

}  // namespace

Region RegionAround(const cv::Mat1i& label, int id, const TruthMap& truth) {
  Polygon cells;
  for (int row = 0; row < label.rows; ++row) {
    for (int col = 0; col < label.cols; ++col) {
      if (label(row, col) == id) cells.push_back(truth.CellCenter(row, col));
    }
  }
  Region region;
  region.id = id;
  region.grade = 1.0;
  region.num_observations = region.num_grass_observations = 10;
  region.area_m2 = static_cast<double>(cells.size()) * truth.cell_size_m * truth.cell_size_m;
  for (const Eigen::Vector2d& corner : MinAreaRectangle(cells)) {
    region.corners_in_world.emplace_back(corner.x(), corner.y(), 0.0);
  }
  return region;
}

PlanRequest RequestFor(const Region& region, const Eigen::Vector2d& wind_in_world) {
  PlanRequest request;
  request.footprint = region.Footprint();
  request.area_m2 = region.area_m2;
  request.grade = region.grade;
  request.num_observations = region.num_observations;
  request.wind_in_world = wind_in_world;
  return request;
}

EngineRun RunOnTruth(const Scenario& scenario,
                     const TruthMap& truth,
                     const Fields& fields,
                     const ApproachOptions& options) {
  EngineRun run;
  run.evaluation.map = TrueElevation(scenario, truth);
  run.evaluation.hazards = TrueHazards(run.evaluation.map, truth);
  for (const Field& field : fields.fields) {
    Site site;
    site.region = RegionAround(fields.label, field.id, truth);
    site.plan = PlanApproach(run.evaluation.map,
                             WithinField(run.evaluation.hazards, field, fields, truth),
                             RequestFor(site.region, scenario.world.wind_in_world),
                             scenario.aircraft,
                             options);
    run.regions.push_back(site.region);
    run.evaluation.sites.push_back(std::move(site));
  }
  return run;
}

}  // namespace freelsd
