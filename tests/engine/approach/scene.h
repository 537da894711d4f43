// Maps made by hand, for the tests of approach/.
#pragma once

#include <functional>

#include <opencv2/imgproc.hpp>

#include "engine/approach/approach.h"

namespace freelsd::scene {

struct Scene {
  ElevationMap map;
  HazardLayers hazards;

  Eigen::Vector2d CellCenter(int row, int col) const {
    return map.grid.north_west_in_world +
           map.grid.cell_size_m * Eigen::Vector2d(col + 0.5, -(row + 0.5));
  }
};

// Distances anew, after hazards were changed; the outside of the grid counts as a hazard.
inline void UpdateDistance(Scene& scene) {
  cv::Mat1b is_free;
  cv::Mat(scene.hazards.hazard == kFree).convertTo(is_free, CV_8U);
  cv::Mat1b padded;
  cv::copyMakeBorder(is_free, padded, 1, 1, 1, 1, cv::BORDER_CONSTANT, cv::Scalar(0));
  cv::Mat1f cells;
  cv::distanceTransform(padded, cells, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  const cv::Rect inner(1, 1, is_free.cols, is_free.rows);
  scene.hazards.distance = cells(inner) * scene.map.grid.cell_size_m;
}

// A seen meadow of num_rows x num_cols cells, centred on the origin; heights by `ground`.
inline Scene Meadow(int num_rows,
                    int num_cols,
                    double cell_size,
                    const std::function<double(const Eigen::Vector2d&)>& ground) {
  Scene scene;
  Grid& grid = scene.map.grid;
  grid.num_rows = num_rows;
  grid.num_cols = num_cols;
  grid.cell_size_m = cell_size;
  grid.north_west_in_world = 0.5 * cell_size * Eigen::Vector2d(-num_cols, num_rows);
  scene.map.elevation = cv::Mat1f(num_rows, num_cols);
  for (int row = 0; row < num_rows; ++row) {
    for (int col = 0; col < num_cols; ++col) {
      scene.map.elevation(row, col) = static_cast<float>(ground(scene.CellCenter(row, col)));
    }
  }
  scene.map.upper = scene.map.elevation.clone();
  scene.map.standard_deviation = cv::Mat1f(num_rows, num_cols, 0.1f);
  scene.map.num_points = cv::Mat1f(num_rows, num_cols, 10.0f);
  scene.hazards.grid = grid;
  scene.hazards.slope = cv::Mat1f(num_rows, num_cols, 0.0f);
  scene.hazards.roughness = cv::Mat1f(num_rows, num_cols, 0.0f);
  scene.hazards.grass = cv::Mat1f(num_rows, num_cols, 1.0f);
  scene.hazards.hazard = cv::Mat1b(num_rows, num_cols, uchar{kFree});
  UpdateDistance(scene);
  return scene;
}

inline Scene FlatMeadow(int num_rows, int num_cols, double cell_size = 1.0) {
  return Meadow(num_rows, num_cols, cell_size, [](const Eigen::Vector2d&) { return 0.0; });
}

// Calls for every cell whose centre lies in the box; distances are not updated.
inline void ForCells(Scene& scene,
                     const Eigen::Vector2d& low,
                     const Eigen::Vector2d& high,
                     const std::function<void(int row, int col)>& change) {
  for (int row = 0; row < scene.map.grid.num_rows; ++row) {
    for (int col = 0; col < scene.map.grid.num_cols; ++col) {
      const Eigen::Vector2d place = scene.CellCenter(row, col);
      if ((place.array() >= low.array()).all() && (place.array() <= high.array()).all()) {
        change(row, col);
      }
    }
  }
}

// A house or a tree: hazard, and as high as given over the ground.
inline void AddBlock(Scene& scene,
                     const Eigen::Vector2d& low,
                     const Eigen::Vector2d& high,
                     double height) {
  ForCells(scene, low, high, [&](int row, int col) {
    scene.map.upper(row, col) += static_cast<float>(height);
    scene.hazards.hazard(row, col) = kHazard;
  });
  UpdateDistance(scene);
}

inline void AddUnseen(Scene& scene, const Eigen::Vector2d& low, const Eigen::Vector2d& high) {
  const float unseen = std::numeric_limits<float>::quiet_NaN();
  ForCells(scene, low, high, [&](int row, int col) {
    scene.map.elevation(row, col) = scene.map.upper(row, col) = unseen;
    scene.map.standard_deviation(row, col) = unseen;
    scene.hazards.slope(row, col) = scene.hazards.roughness(row, col) = unseen;
    scene.hazards.grass(row, col) = unseen;
    scene.hazards.hazard(row, col) = kUnseen;
  });
  UpdateDistance(scene);
}

inline Polygon Box(const Eigen::Vector2d& low, const Eigen::Vector2d& high) {
  return {low, {high.x(), low.y()}, high, {low.x(), high.y()}};
}

// Of a region that is large enough, whatever part of it the footprint lets touch down on.
inline PlanRequest Request(const Polygon& footprint,
                           const std::optional<Eigen::Vector2d>& wind_in_world) {
  PlanRequest request;
  request.footprint = footprint;
  request.area_m2 = 4000.0;
  request.grade = 1.0;
  request.num_observations = 5;
  request.wind_in_world = wind_in_world;
  return request;
}

// Small circles, so that small maps hold them: in 4 m/s of wind a final of 45.9 m, a radius
// of 19.7.
inline Aircraft Nimble() {
  Aircraft aircraft = *AircraftProfile("small");
  aircraft.max_bank_deg = 45.0;
  return aircraft;
}

// One way down: into the wind, from the aircraft's own approach height. The paper's rule.
inline ApproachOptions OneWay() {
  ApproachOptions options;
  options.start_height_ratios = {1.0};
  options.max_crosswind_ratio = 0.0;
  return options;
}

inline Plan PlanOn(const Scene& on,
                   const PlanRequest& request,
                   const Aircraft& aircraft = Nimble(),
                   const ApproachOptions& options = {}) {
  return PlanApproach(on.map, on.hazards, request, aircraft, options);
}

}  // namespace freelsd::scene
