// Pictures from straight above, painted by hand, for the tests of what looks like grass.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <random>

#include "engine/cover/cover.h"

namespace freelsd::photo {

using Color = cv::Vec3d;  // BGR
using Paint = std::function<Color(const Eigen::Vector2d& place_in_world)>;

// A meadow, and a green of which a share is missing, as in a rut.
const Color kGreen{62.0, 120.0, 74.0};
// Deviation of the brightness of one cell; that of its colour is smaller by as much.
constexpr double kNoise = 8.0;
constexpr double kColorNoiseRatio = 0.25;

// The mean of the paint over each cell, with noise; seen all over. Centred on the origin.
inline Orthophoto Painted(double side_m, const Paint& paint, double noise = kNoise) {
  constexpr double kCellM = 0.25;
  constexpr int kNumParts = 3;
  Orthophoto photo;
  photo.grid.cell_size_m = kCellM;
  photo.grid.num_rows = photo.grid.num_cols = static_cast<int>(std::lround(side_m / kCellM));
  photo.grid.north_west_in_world = {-0.5 * side_m, 0.5 * side_m};
  photo.image = cv::Mat3b(photo.grid.num_rows, photo.grid.num_cols);
  photo.seen = cv::Mat1b(photo.image.size(), uint8_t{255});
  std::mt19937 random(5);
  std::normal_distribution<double> error(0.0, 1.0);
  for (int row = 0; row < photo.image.rows; ++row) {
    for (int col = 0; col < photo.image.cols; ++col) {
      const Eigen::Vector2d center = photo.grid.CellCenter(row, col);
      Color sum(0.0, 0.0, 0.0);
      for (int i = 0; i < kNumParts * kNumParts; ++i) {
        const Eigen::Vector2d part(i % kNumParts - 1, i / kNumParts - 1);
        sum += paint(center + part * (kCellM / kNumParts)) / double(kNumParts * kNumParts);
      }
      const double shade = noise * error(random);
      for (int c = 0; c < 3; ++c) {
        const double value = sum[c] + shade + kColorNoiseRatio * noise * error(random);
        photo.image(row, col)[c] = cv::saturate_cast<uint8_t>(value);
      }
    }
  }
  return photo;
}

// Cells of one metre over the same ground.
inline Grid MapGridOf(const Orthophoto& photo) {
  const double side_m = photo.grid.num_rows * photo.grid.cell_size_m;
  return {photo.grid.north_west_in_world, 1.0, int(std::lround(side_m)), int(std::lround(side_m))};
}

inline void MakeUnseen(Orthophoto& photo, const cv::Rect& cells) {
  photo.image(cells).setTo(cv::Scalar::all(0.0));
  photo.seen(cells).setTo(0);
}

// Along and across lines that run `turn_deg` counter-clockwise from east.
inline Eigen::Vector2d AlongAndAcross(const Eigen::Vector2d& place, double turn_deg) {
  const double turn = RadFromDeg(turn_deg);
  return {place.x() * std::cos(turn) + place.y() * std::sin(turn),
          -place.x() * std::sin(turn) + place.y() * std::cos(turn)};
}

// Distance from the nearest multiple of the spacing.
inline double OffMultiple(double value, double spacing) {
  return std::abs(value - spacing * std::round(value / spacing));
}

// Looks straight down from 100 m over the origin, image top north; the mask covers 100 x 100 m with
// one pixel per metre.
inline KindView NadirView(uint8_t value) {
  KindView view;
  view.world_from_camera.rotation = Eigen::Quaterniond(0, 1, 0, 0);
  view.world_from_camera.translation = {0.0, 0.0, 200.0};
  view.camera.width_px = view.camera.height_px = 400;
  view.camera.fx_px = view.camera.fy_px = 400.0;
  view.camera.cx_px = view.camera.cy_px = 199.5;
  view.picture.grass = cv::Mat1b(100, 100, value);
  view.picture.image_px_per_px = 4.0;
  return view;
}

// As many as it takes to call a cell grass.
inline std::vector<KindView> TwoNadirViews(uint8_t value) { return {2, NadirView(value)}; }

}  // namespace freelsd::photo
