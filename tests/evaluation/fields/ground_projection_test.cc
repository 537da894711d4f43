// Outlines on a hill whose shape is known, seen by tilted cameras with a lens that distorts.
#include "tests/evaluation/fields/ground_projection.h"

#include <cmath>
#include <limits>

#include <doctest/doctest.h>

#include "tests/evaluation/fields/labelled_ground.h"
#include "tests/evaluation/fields/outline_agreement.h"

namespace freelsd {
namespace {

constexpr double kMaxErrorM = 0.3;

double HillHeight(const Eigen::Vector2d& place) {
  return 30.0 + 0.06 * place.x() + 4.0 * std::sin(place.y() / 25.0);
}

ElevationMap HillMap() {
  ElevationMap map;
  map.grid = GridAround({-120.0, -120.0}, {120.0, 120.0}, 1.0);
  map.elevation = cv::Mat1f(map.grid.num_rows, map.grid.num_cols);
  for (int row = 0; row < map.grid.num_rows; ++row) {
    for (int col = 0; col < map.grid.num_cols; ++col) {
      map.elevation(row, col) = static_cast<float>(HillHeight(map.grid.CellCenter(row, col)));
    }
  }
  return map;
}

GroundHeights HillHeights() {
  const ElevationMap map = HillMap();
  return {map.grid, map.elevation};
}

// Two views from 90 m above the origin's height, tilted by about ten degrees.
AdjustedBlock TwoViews() {
  AdjustedBlock block;
  block.camera = {.width_px = 2000,
                  .height_px = 1500,
                  .fx_px = 1400.0,
                  .fy_px = 1400.0,
                  .cx_px = 990.0,
                  .cy_px = 760.0,
                  .distortion = DistortionModel::kRadTan,
                  .coefficients = {-0.05, 0.01, 0.001, -0.001},
                  .source = CameraSource::kCalibrated,
                  .readout_s = 0.0,
                  .readout = {}};
  const Eigen::Quaterniond down(0.0, 1.0, 0.0, 0.0);
  for (const double side : {-1.0, 1.0}) {
    AdjustedView view;
    view.frame_id = side < 0.0 ? "west.JPG" : "east.JPG";
    const Eigen::AngleAxisd tilt(0.17 * side, Eigen::Vector3d(0.3, 1.0, 0.0).normalized());
    view.world_from_camera = {Eigen::Quaterniond(tilt) * down, {25.0 * side, 5.0, 120.0}};
    view.is_connected = true;
    block.views.push_back(view);
  }
  return block;
}

// `raise`: metres above the hill.
Outline Photographed(const AdjustedBlock& block,
                     size_t view,
                     const Polygon& field,
                     double raise = 0.0) {
  Outline outline{"F1", OutlineKind::kLand, view == 0 ? "west" : "east", 0.0, {}};
  const Rigid3d camera_from_world = Inverse(block.views[view].world_from_camera);
  for (const Eigen::Vector2d& corner : field) {
    const Eigen::Vector3d point(corner.x(), corner.y(), HillHeight(corner) + raise);
    const auto pixel = block.CameraOf(view).ImageFromCamera(camera_from_world * point);
    REQUIRE(pixel.has_value());
    outline.corners_in_image.push_back(*pixel);
  }
  return outline;
}

TEST_CASE("ground projection: an outline on a hill returns within 0.3 m from two views") {
  const AdjustedBlock block = TwoViews();
  const ElevationMap map = HillMap();
  const GroundProjection projection(block, HillHeights());
  const Polygon field{{-30.0, -20.0}, {25.0, -25.0}, {30.0, 30.0}, {-20.0, 25.0}};
  std::vector<GroundOutline> outlines;
  for (size_t view = 0; view < 2; ++view) {
    const Outline outline = Photographed(block, view, field);
    const auto polygon = projection.OnGround(outline);
    REQUIRE(polygon.has_value());
    CHECK(MeanBorderDistance(*polygon, field) < kMaxErrorM);
    for (const Eigen::Vector2d& corner : field) {
      double nearest = std::numeric_limits<double>::infinity();
      for (const Eigen::Vector2d& point : *polygon) {
        nearest = std::min(nearest, (point - corner).norm());
      }
      CHECK(nearest < kMaxErrorM);
    }
    outlines.push_back({outline.id, outline.kind, 0.0, outline.photograph, *polygon});
  }
  const Disagreement disagreement = MakeLabelledGround(outlines, map, 1.0).disagreement;
  CHECK(disagreement.num_pairs == 1);
  CHECK(disagreement.median_m < kMaxErrorM);
  CHECK(disagreement.mean_overlap_ratio > 0.95);
}

TEST_CASE("ground projection: the top of a pole agrees in two views only at its height") {
  constexpr double kHeightM = 9.0;
  const AdjustedBlock block = TwoViews();
  const GroundProjection projection(block, HillHeights());
  const Polygon top{{9.0, 9.0}, {11.0, 9.0}, {11.0, 11.0}, {9.0, 11.0}};
  const Outline west = Photographed(block, 0, top, kHeightM);
  const Outline east = Photographed(block, 1, top, kHeightM);
  CHECK(MeanBorderDistance(*projection.OnGround(west, kHeightM), top) < kMaxErrorM);
  CHECK(MeanBorderDistance(*projection.OnGround(east, kHeightM), top) < kMaxErrorM);
  CHECK(MeanBorderDistance(*projection.OnGround(west), *projection.OnGround(east)) > 3.0);
}

TEST_CASE("ground projection: a photograph without a connected view places nothing") {
  AdjustedBlock block = TwoViews();
  block.views[1].is_connected = false;
  const GroundProjection projection(block, HillHeights());
  const Outline outline{"F1", OutlineKind::kLand, "east", 0.0, {{1, 1}, {9, 1}, {9, 9}}};
  CHECK(!projection.OnGround(outline).has_value());
}

}  // namespace
}  // namespace freelsd
