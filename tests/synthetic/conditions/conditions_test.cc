// What light, air and camera do to a photograph of a plain world.
#include "tests/synthetic/conditions/conditions.h"

#include <cmath>

#include <doctest/doctest.h>
#include <opencv2/imgproc.hpp>

#include "tests/synthetic/flight_files.h"

namespace freelsd {
namespace {

// Straight down from 40 m, the top of the picture towards the north.
Rigid3d FromAbove() {
  Rigid3d world_from_camera;
  world_from_camera.rotation = Eigen::AngleAxisd(kPi, Eigen::Vector3d::UnitX());
  world_from_camera.translation << 0.0, 0.0, 40.0;
  return world_from_camera;
}

World Plane() {
  WorldOptions options;
  options.size_m = 80.0;
  options.cell_size_m = 0.1;
  return MakeMeadowPlane(options);
}

// One white line from south to north, or from west to east.
World Striped(bool is_northward) {
  World world = Plane();
  world.radiance.setTo(cv::Scalar::all(60.0));
  const int middle = world.num_cells() / 2;
  cv::Mat line = is_northward ? world.radiance.colRange(middle, middle + 3)
                              : world.radiance.rowRange(middle, middle + 3);
  line.setTo(cv::Scalar::all(220.0));
  return world;
}

RenderOptions Quiet() {
  RenderOptions options;
  options.lens_blur_px = 0.0;
  options.sensor_noise = 0.0;
  options.exposure_drift_ratio = 0.0;
  options.vignetting_ratio = 0.0;
  return options;
}

cv::Mat1b GreyOf(const cv::Mat& image) {
  cv::Mat1b grey;
  cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  return grey;
}

// Column of the line in a row of the picture: the centre of what is brighter than the ground.
double ColumnOfLine(const cv::Mat1b& grey, int row) {
  double sum = 0.0, weight = 0.0;
  for (int col = 0; col < grey.cols; ++col) {
    const double excess = std::max(0, grey(row, col) - 70);
    sum += excess * col;
    weight += excess;
  }
  return sum / weight;
}

TEST_CASE("conditions: a rolling shutter bends a line by speed times readout") {
  constexpr double kMaxErrorPx = 0.3;
  const World world = Striped(true);
  const Camera camera = PaperCamera(376, 240);
  RenderOptions options = Quiet();
  options.readout_s = 0.05;
  CameraMotion motion;
  motion.velocity_in_world << 20.0, 0.0, 0.0;  // eastwards: later rows see the line farther west
  const cv::Mat1b grey = GreyOf(Renderer(world).Render(camera, FromAbove(), options, 0, motion));
  const double moved = ColumnOfLine(grey, 220) - ColumnOfLine(grey, 20);
  const double expected = -20.0 * 0.05 * (200.0 / 240.0) * camera.fx_px / 40.0;
  CHECK(std::abs(moved - expected) < kMaxErrorPx);
  const cv::Mat1b still = GreyOf(Renderer(world).Render(camera, FromAbove(), options, 0));
  CHECK(std::abs(ColumnOfLine(still, 220) - ColumnOfLine(still, 20)) < kMaxErrorPx);
}

TEST_CASE("conditions: motion smears across the way and not along it") {
  const Camera camera = PaperCamera(376, 240);
  RenderOptions options = Quiet();
  options.exposure_s = 1.0 / 30.0;
  CameraMotion motion;
  motion.velocity_in_world << 20.0, 0.0, 0.0;
  const auto contrast = [&](bool is_northward, bool moves) {
    const World world = Striped(is_northward);
    double brightest = 0.0;
    cv::minMaxLoc(GreyOf(Renderer(world).Render(
                      camera, FromAbove(), options, 0, moves ? motion : CameraMotion{})),
                  nullptr,
                  &brightest);
    return brightest;
  };
  CHECK(contrast(true, true) < contrast(true, false) - 40.0);
  CHECK(contrast(false, true) > contrast(false, false) - 10.0);
}

TEST_CASE("conditions: haze, cast and exposure change a picture by what they say") {
  constexpr double kMaxError = 1.5;
  World world = Plane();
  world.radiance.setTo(cv::Scalar::all(100.0));
  const auto mean = [&](const RenderOptions& options, int frame) {
    return cv::mean(Renderer(world).Render(PaperCamera(94, 60), FromAbove(), options, frame));
  };
  RenderOptions haze = Quiet();
  haze.haze_ratio = 0.2;
  CHECK(std::abs(mean(haze, 0)[1] - (0.8 * 100.0 + 0.2 * 200.0)) < kMaxError);
  RenderOptions cast = Quiet();
  cast.color_gain = {1.1f, 0.8f, 1.0f};
  CHECK(std::abs(mean(cast, 0)[0] - 110.0) < kMaxError);
  CHECK(std::abs(mean(cast, 0)[1] - 80.0) < kMaxError);
  RenderOptions steps = Quiet();
  steps.exposure_step_ratio = 0.25;
  CHECK(mean(steps, 0)[1] == mean(steps, 6)[1]);
  CHECK(mean(steps, 0)[1] != mean(steps, 7)[1]);
}

TEST_CASE("conditions: low sun lengthens shadows, and clouds soften them") {
  WorldOptions options;
  options.seed = 1000;
  options.size_m = 120.0;
  const auto shaded_ratio = [&](double sun_elevation_deg, double sky_share) {
    World world = MakeMeadowPlane(options);
    world.Build(House{.center = {0.0, 0.0}, .heading = 0.5});
    world.Paint();
    Conditions conditions = PlainConditions(1);
    conditions.sun_elevation_deg = sun_elevation_deg;
    conditions.sky_share = sky_share;
    LightFor(conditions, world);
    cv::Mat1b grey = GreyOf(world.radiance), albedo = GreyOf(world.albedo);
    const cv::Mat1b is_shaded = grey < 0.7 * albedo;
    return cv::countNonZero(is_shaded) / static_cast<double>(grey.total());
  };
  CHECK(shaded_ratio(15.0, 0.36) > 1.5 * shaded_ratio(45.0, 0.36));
  CHECK(shaded_ratio(45.0, 0.8) < 0.5 * shaded_ratio(45.0, 0.36));
}

TEST_CASE("conditions: a seed has its own, and each kind occurs among a hundred seeds") {
  CHECK(RecordedConditions(5).camera.haze_ratio == RecordedConditions(5).camera.haze_ratio);
  int num_low_sun = 0, num_clouds = 0, num_rolling = 0, num_coarse = 0, num_cast = 0;
  for (uint64_t seed = 1000; seed < 1100; ++seed) {
    const Conditions conditions = RecordedConditions(seed);
    num_low_sun += !std::isnan(conditions.sun_elevation_deg);
    num_clouds += conditions.sky_share > 0.5;
    num_rolling += conditions.camera.readout_s > 0.0;
    num_coarse += conditions.jpeg_quality < 80;
    num_cast += conditions.camera.color_gain[1] < 0.8f;
  }
  CHECK(num_low_sun > 5);
  CHECK(num_clouds > 5);
  CHECK(num_rolling > 25);
  CHECK(num_coarse > 15);
  CHECK(num_cast > 2);
}

}  // namespace
}  // namespace freelsd
