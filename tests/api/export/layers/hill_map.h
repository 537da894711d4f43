// A site's map with a known hill, for tests of what is made of it.
#pragma once

#include <cmath>
#include <limits>

#include "api/export/layers/layers.h"
#include "api/stored/stored.h"
#include "tests/engine/hazard/assess.h"

namespace freelsd {

constexpr int kHillRows = 60;
constexpr int kHillCols = 80;

// Flat ground at 2 m with a hill of 12 m in the north-east and grass in the west; the south-western
// corner (rows >= 50, columns < 10) is unseen. North-west corner at east -30, north 40.
inline SiteMap HillMap() {
  SiteMap site_map;
  auto& [map, layers] = site_map;
  map.grid = {{-30.0, 40.0}, 1.0, kHillRows, kHillCols};
  const float unseen = std::numeric_limits<float>::quiet_NaN();
  map.elevation = cv::Mat1f(kHillRows, kHillCols, unseen);
  map.standard_deviation = map.elevation.clone();
  map.num_points = map.elevation.clone();
  for (int row = 0; row < kHillRows; ++row) {
    for (int col = 0; col < kHillCols; ++col) {
      if (row >= 50 && col < 10) continue;
      const double squared = std::pow(row - 12.0, 2) + std::pow(col - 65.0, 2);
      map.elevation(row, col) = static_cast<float>(2.0 + 12.0 * std::exp(-squared / 72.0));
      map.standard_deviation(row, col) = 0.1f;
      map.num_points(row, col) = 40.0f;
    }
  }
  map.upper = map.elevation + 0.2;
  KindView view;
  view.world_from_camera.rotation = Eigen::Quaterniond(0, 1, 0, 0);
  view.world_from_camera.translation = {10.0, 10.0, 102.0};
  view.camera.width_px = view.camera.height_px = 200;
  view.camera.fx_px = view.camera.fy_px = 200.0;
  view.camera.cx_px = view.camera.cy_px = 99.5;
  view.picture.grass = cv::Mat1b(200, 200, 255);
  view.picture.grass.colRange(140, 200).setTo(1);
  layers = AssessHazards(map, {view, view}, {}, {});
  return site_map;
}

}  // namespace freelsd
