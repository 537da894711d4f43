// A crop that looks like grass stands above what surrounds it.
#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include <doctest/doctest.h>

#include "engine/hazard/hazard.h"

namespace freelsd {
namespace {

constexpr int kNumCells = 80;
constexpr double kHalfFieldM = 20.0;
constexpr double kCropM = 0.5;
constexpr double kNoiseM = 0.05;
// Cells here and there that noise has parted from their piece: no disc fits.
constexpr int kMaxNumStray = 10;

bool IsField(double east, double north) {
  return std::max(std::abs(east), std::abs(north)) < kHalfFieldM;
}

// Of the middle field, looking straight down from 100 m; one pixel per metre.
GrassView ViewOfField() {
  GrassView view;
  view.world_from_camera.rotation = Eigen::Quaterniond(0, 1, 0, 0);
  view.world_from_camera.translation = {0.0, 0.0, 100.0};
  view.camera.width_px = view.camera.height_px = 400;
  view.camera.fx_px = view.camera.fy_px = 400.0;
  view.camera.cx_px = view.camera.cy_px = 199.5;
  view.mask = cv::Mat1b(100, 100, uchar{1});
  const int half = static_cast<int>(kHalfFieldM);
  view.mask(cv::Rect(50 - half, 50 - half, 2 * half, 2 * half)).setTo(255);
  view.image_px_per_mask_px = 4.0;
  return view;
}

// Heights by place, with noise; the same every time.
ElevationMap MapOf(const std::function<double(double, double)>& height) {
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0.0, kNoiseM);
  ElevationMap map;
  map.grid = {{-0.5 * kNumCells, 0.5 * kNumCells}, 1.0, kNumCells, kNumCells};
  map.elevation = cv::Mat1f(kNumCells, kNumCells);
  for (int row = 0; row < kNumCells; ++row) {
    for (int col = 0; col < kNumCells; ++col) {
      const Eigen::Vector2d place = map.grid.CellCenter(row, col);
      map.elevation(row, col) = static_cast<float>(height(place.x(), place.y()) + noise(random));
    }
  }
  map.upper = map.elevation + 0.1;
  map.standard_deviation = cv::Mat1f(map.elevation.size(), 0.1f);
  map.num_points = cv::Mat1f(map.elevation.size(), 50.0f);
  return map;
}

HazardOptions WithRule() {
  HazardOptions options;
  options.max_raised_edge_ratio = 0.4;
  options.min_telling_edge_ratio = 0.12;
  return options;
}

int NumFree(const ElevationMap& map, const HazardOptions& options = WithRule()) {
  // Noise alone reaches the default roughness here and there.
  const HazardLimits limits{.max_slope_deg = 10.0, .max_roughness_m = 0.8};
  return cv::countNonZero(AssessHazards(map, {ViewOfField()}, limits, options).hazard == kFree);
}

TEST_CASE("standing growth: a green crop above its surroundings is no grass, a meadow is") {
  const auto crop = [](double x, double y) { return IsField(x, y) ? kCropM : 0.0; };
  CHECK(NumFree(MapOf(crop)) <= kMaxNumStray);
  CHECK(NumFree(MapOf([](double, double) { return 0.0; })) > 1000);
  // Switched off, the crop is taken for what it looks like.
  CHECK(NumFree(MapOf(crop), {}) > 900);
}

TEST_CASE("standing growth: slope and relief hide neither crop nor meadow") {
  const auto relief = [](double x, double y) {
    return 0.08 * x + 0.03 * y + 0.6 * std::sin(x / 25.0) * std::cos(y / 30.0);
  };
  CHECK(NumFree(MapOf(relief)) > 800);
  CHECK(NumFree(MapOf([&](double x, double y) {
          return relief(x, y) + (IsField(x, y) ? kCropM : 0.0);
        })) <= kMaxNumStray);
}

TEST_CASE("standing growth: hedges on all sides and a ditch on one do not make a meadow a crop") {
  const auto hedged = [](double x, double y) {
    const double outside = std::max(std::abs(x), std::abs(y)) - kHalfFieldM;
    if (x > 0.0 && x - kHalfFieldM > 2.5 && x - kHalfFieldM < 5.0) return -0.8;  // ditch, east
    return outside > 0.5 && outside < 2.5 && x < kHalfFieldM ? 2.0 : 0.0;
  };
  CHECK(NumFree(MapOf(hedged)) > 800);
}

TEST_CASE("standing growth: green between higher banks, and a field amid woods, are not known") {
  const auto pond = [](double x, double y) { return IsField(x, y) ? -0.6 : 0.0; };
  CHECK(NumFree(MapOf(pond)) <= kMaxNumStray);
  const auto clearing = [](double x, double y) { return IsField(x, y) ? 0.0 : 9.0; };
  CHECK(NumFree(MapOf(clearing)) <= kMaxNumStray);
}

TEST_CASE("standing growth: a crop and a meadow that touch by a gap in the step are two") {
  // All of the map but a road in the south looks like grass; the crop's edge is not seen for 4 m of
  // each side.
  const auto height = [](double x, double y) {
    const bool is_gap = std::min(std::abs(x), std::abs(y)) < 2.0;
    const double outside = std::max(std::abs(x), std::abs(y)) - kHalfFieldM;
    if (is_gap) return kCropM * std::clamp(0.5 - outside / 8.0, 0.0, 1.0);
    return outside < 0.0 ? kCropM : 0.0;
  };
  GrassView view = ViewOfField();
  view.mask.setTo(255);
  const int num_outside = (view.mask.rows - kNumCells) / 2, num_road = 12;
  view.mask.rowRange(view.mask.rows - num_outside - num_road, view.mask.rows).setTo(1);
  const ElevationMap map = MapOf(height);
  const HazardLayers layers =
      AssessHazards(map, {view}, {.max_slope_deg = 10.0, .max_roughness_m = 0.8}, WithRule());
  const cv::Point middle(kNumCells / 2, kNumCells / 2);
  CHECK(layers.grass(middle) == 0.0f);
  CHECK(layers.grass(cv::Point(5, 5)) > 0.8f);
}

TEST_CASE("standing growth: where nothing around a field was seen nothing is judged by it") {
  ElevationMap map = MapOf([](double, double) { return 0.0; });
  for (int row = 0; row < kNumCells; ++row) {
    for (int col = 0; col < kNumCells; ++col) {
      const Eigen::Vector2d place = map.grid.CellCenter(row, col);
      if (IsField(place.x(), place.y())) continue;
      map.elevation(row, col) = map.upper(row, col) = std::numeric_limits<float>::quiet_NaN();
    }
  }
  CHECK(NumFree(map) > 500);
}

}  // namespace
}  // namespace freelsd
