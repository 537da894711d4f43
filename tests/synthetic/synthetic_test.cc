#include <cmath>
#include <limits>

#include <doctest/doctest.h>
#include <opencv2/imgproc.hpp>

#include "tests/synthetic/flight_files.h"
#include "tests/synthetic/flight_plan.h"
#include "tests/synthetic/renderer.h"
#include "tests/synthetic/truth.h"
#include "tests/synthetic/world.h"

namespace freelsd {
namespace {

constexpr double kHeightM = 100.0;

WorldOptions SmallWorld(double size_m, double cell_size_m) {
  WorldOptions options;
  options.size_m = size_m;
  options.cell_size_m = cell_size_m;
  return options;
}

RenderOptions PerfectLens() {
  RenderOptions options;
  options.lens_blur_px = 0.0;
  options.sensor_noise = 0.0;
  options.exposure_drift_ratio = 0.0;
  options.vignetting_ratio = 0.0;
  return options;
}

// Camera of an aircraft over (x, y) with that attitude, in degrees.
Rigid3d CameraOver(const Eigen::Vector3d& position_in_world,
                   double roll,
                   double pitch,
                   double yaw) {
  AutopilotSample sample;
  sample.position_in_world = position_in_world;
  sample.attitude = {.roll = RadFromDeg(roll), .pitch = RadFromDeg(pitch), .yaw = RadFromDeg(yaw)};
  return WorldFromBody(sample) * Rig{}.body_from_camera;
}

// A black plane with one white disc.
World WorldWithMarker(const Eigen::Vector2d& center, double radius_m) {
  World world = MakeMeadowPlane(SmallWorld(150.0, 0.1));
  world.radiance.setTo(cv::Scalar::all(0));
  const cv::Range rows = world.CellsAround(center.y(), radius_m);
  const cv::Range cols = world.CellsAround(center.x(), radius_m);
  for (int row = rows.start; row < rows.end; ++row) {
    for (int col = cols.start; col < cols.end; ++col) {
      const Eigen::Vector2d place(world.CellCenter(col), world.CellCenter(row));
      if ((place - center).norm() <= radius_m) world.radiance(row, col) = {255, 255, 255};
    }
  }
  return world;
}

Eigen::Vector2d CentroidOfLight(const cv::Mat& image) {
  cv::Mat grey;
  cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  const cv::Moments moments = cv::moments(grey);
  REQUIRE(moments.m00 > 0.0);
  return {moments.m10 / moments.m00, moments.m01 / moments.m00};
}

double MeanBrightness(const World& world, const Eigen::Vector2d& center, double reach_m) {
  const cv::Range rows = world.CellsAround(center.y(), reach_m);
  const cv::Range cols = world.CellsAround(center.x(), reach_m);
  const cv::Scalar mean = cv::mean(world.radiance(rows, cols));
  return (mean[0] + mean[1] + mean[2]) / 3.0;
}

TEST_CASE("renderer: a marker appears where the camera model says, within 0.1 px") {
  constexpr double kMaxErrorPx = 0.1;
  Camera camera = PaperCamera(752, 480);
  for (const Eigen::Vector2d& center :
       {Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(31.0, -22.0), Eigen::Vector2d(-24.0, 17.0)}) {
    const World world = WorldWithMarker(center, 1.2);
    const Renderer renderer(world);
    for (const bool is_distorted : {false, true}) {
      camera.distortion = is_distorted ? DistortionModel::kRadTan : DistortionModel::kNone;
      camera.coefficients.clear();
      if (is_distorted) camera.coefficients = {-0.2, 0.05, 0.001, -0.001};
      const Rigid3d world_from_camera = CameraOver({3.0, -2.0, kHeightM}, 4.0, -3.0, 35.0);
      const auto expected = camera.ImageFromCamera(Inverse(world_from_camera) *
                                                   Eigen::Vector3d(center.x(), center.y(), 0.0));
      REQUIRE(expected);
      const cv::Mat image = renderer.Render(camera, world_from_camera, PerfectLens(), 0);
      CHECK((CentroidOfLight(image) - *expected).norm() < kMaxErrorPx);
    }
  }
}

TEST_CASE("renderer: flying north, north is up and east is right") {
  const Camera camera = PaperCamera(376, 240);
  const Rigid3d world_from_camera = CameraOver({0.0, 0.0, kHeightM}, 0.0, 0.0, 0.0);
  const World north = WorldWithMarker({0.0, 20.0}, 2.0);
  const Eigen::Vector2d up =
      CentroidOfLight(Renderer(north).Render(camera, world_from_camera, PerfectLens(), 0));
  CHECK(up.y() < camera.cy_px - 30.0);
  CHECK(std::abs(up.x() - camera.cx_px) < 0.5);
  const World east = WorldWithMarker({20.0, 0.0}, 2.0);
  const Eigen::Vector2d right =
      CentroidOfLight(Renderer(east).Render(camera, world_from_camera, PerfectLens(), 0));
  CHECK(right.x() > camera.cx_px + 30.0);
  CHECK(std::abs(right.y() - camera.cy_px) < 0.5);
}

TEST_CASE("renderer: a house hides what is behind it and nothing else") {
  World world = MakeMeadowPlane(SmallWorld(150.0, 0.15));
  world.Build({.center = {30.0, 0.0},
               .heading = 0.0,
               .length_m = 12.0,
               .width_m = 8.0,
               .eaves_m = 8.0,
               .ridge_m = 8.0});
  const Renderer renderer(world);
  const Eigen::Vector3d camera(0.0, 0.0, 40.0);
  // The far eaves at x = 34, z = 8 throw their shade to x = 34 * 40 / 32 = 42.5 m.
  const auto hidden = renderer.FirstHit(camera, Eigen::Vector3d(40.0, 0.0, 0.0) - camera);
  REQUIRE(hidden);
  CHECK(hidden->z() == doctest::Approx(8.0).epsilon(0.01));
  for (const double x : {20.0, 25.5, 43.5, 60.0}) {
    const auto seen = renderer.FirstHit(camera, Eigen::Vector3d(x, 0.0, 0.0) - camera);
    REQUIRE(seen);
    CHECK(seen->x() == doctest::Approx(x).epsilon(0.001));
    CHECK(std::abs(seen->z()) < 0.01);
  }
}

TEST_CASE(
    "renderer: the hit lies on the surface and nothing stands before it, over wood and farm") {
  const World world = MakeFarmland(SmallWorld(600.0, 0.4));
  const Renderer renderer(world);
  const Eigen::Vector3d camera(-60.0, 20.0, 110.0);
  int num_on_trees = 0;
  for (double x = -220.0; x <= 120.0; x += 17.0) {
    for (double y = -150.0; y <= 150.0; y += 13.0) {
      const Eigen::Vector3d ray = Eigen::Vector3d(x, y, 0.0) - camera;
      const auto hit = renderer.FirstHit(camera, ray);
      REQUIRE(hit);
      // Vertical walls are as steep as the grid allows: a few centimetres remain on them.
      CHECK(std::abs(hit->z() - world.SurfaceHeight(hit->x(), hit->y())) < 0.15);
      const double depth = (hit->z() - camera.z()) / ray.z();
      const double step = 0.1 / ray.head<2>().norm();
      for (double t = std::max(0.0, depth - 400.0 * step); t < depth - 2.5 * step; t += step) {
        const Eigen::Vector3d point = camera + t * ray;
        REQUIRE(point.z() > world.SurfaceHeight(point.x(), point.y()) - 0.05);
      }
      if (world.CoverAt(hit->x(), hit->y()) == Cover::kTree) ++num_on_trees;
    }
  }
  CHECK(num_on_trees > 20);
}

TEST_CASE("renderer: a ray from outside the world, or one that climbs, does no harm") {
  const World world = MakeMeadowPlane(SmallWorld(40.0, 0.5));
  const Renderer renderer(world);
  const auto hit = renderer.FirstHit({500.0, -300.0, 80.0}, {0.4, 0.1, -1.0});
  REQUIRE(hit);
  CHECK(std::abs(hit->z()) < 1e-6);
  CHECK_FALSE(renderer.FirstHit({0.0, 0.0, 80.0}, {1.0, 0.0, 0.1}));
}

TEST_CASE("world: the same seed gives the same bytes, another seed another world") {
  WorldOptions options = SmallWorld(240.0, 0.5);
  const World first = MakeFarmland(options);
  const World again = MakeFarmland(options);
  CHECK(cv::norm(first.radiance, again.radiance, cv::NORM_INF) == 0.0);
  CHECK(cv::norm(first.surface, again.surface, cv::NORM_INF) == 0.0);
  options.seed = 2;
  CHECK(cv::norm(first.surface, MakeFarmland(options).surface, cv::NORM_INF) > 1.0);

  const Camera camera = PaperCamera(188, 120);
  const Rigid3d world_from_camera = CameraOver({5.0, 5.0, kHeightM}, 1.0, 2.0, 30.0);
  const cv::Mat image = Renderer(first).Render(camera, world_from_camera, RenderOptions{}, 3);
  const cv::Mat same = Renderer(again).Render(camera, world_from_camera, RenderOptions{}, 3);
  const cv::Mat next = Renderer(again).Render(camera, world_from_camera, RenderOptions{}, 4);
  CHECK(cv::norm(image, same, cv::NORM_INF) == 0.0);
  CHECK(cv::norm(image, next, cv::NORM_INF) > 0.0);
}

TEST_CASE("world: a house throws its shadow away from the sun") {
  World world = MakeMeadowPlane(SmallWorld(100.0, 0.2));
  world.Build({.eaves_m = 6.0, .ridge_m = 6.0});
  world.Paint();
  world.Light();
  const Eigen::Vector2d away = -world.sun_in_world.head<2>().normalized();
  const double shaded = MeanBrightness(world, 9.0 * away, 0.5);
  const double sunny = MeanBrightness(world, -9.0 * away, 0.5);
  CHECK(shaded < 0.55 * sunny);
  CHECK(shaded > 0.25 * sunny);
}

TEST_CASE("world: meadow has the colour and contrast of grass in aerial photographs") {
  const World world = MakeMeadowPlane(SmallWorld(150.0, 0.15));
  const cv::Mat image = Renderer(world).Render(
      PaperCamera(376, 240), CameraOver({0.0, 0.0, 50.0}, 0.0, 0.0, 0.0), RenderOptions{}, 0);
  cv::Mat hsv;
  cv::cvtColor(image, hsv, cv::COLOR_BGR2HSV);
  cv::Scalar mean, sd;
  cv::meanStdDev(hsv, mean, sd);
  // Ranges of the means of labelled grass: OpenCV's hue 36..43, saturation 66..172.
  CHECK(mean[0] > 35.0);
  CHECK(mean[0] < 47.0);
  CHECK(mean[1] > 66.0);
  CHECK(mean[1] < 172.0);
  CHECK(sd[2] > 6.0);
  CHECK(sd[2] < 25.0);
}

TEST_CASE("truth: a tree on final blocks it, and one upwind does not") {
  const Aircraft aircraft = AircraftProfile("small").value();
  World world = MakeMeadowPlane(SmallWorld(300.0, 0.5));  // wind blows east
  const double free = FinalReserve(world, aircraft, {0.0, 0.0});
  CHECK(free > 0.0);
  world.Plant(Tree{.center = {-30.0, 0.0}});
  CHECK(FinalReserve(world, aircraft, {0.0, 0.0}) == doctest::Approx(free));
  world.Plant(Tree{.center = {16.0, 0.0}});
  CHECK(FinalReserve(world, aircraft, {0.0, 0.0}) < 0.0);
  // Heading west, left is south: a tree there blocks that circle only.
  CHECK(LoiterReserve(world, aircraft, {0.0, 0.0}, 1) > 0.0);
  world.Plant(Tree{.center = {46.0, -68.0}, .height_m = 14.0});
  CHECK(LoiterReserve(world, aircraft, {0.0, 0.0}, 1) < 0.0);
  CHECK(LoiterReserve(world, aircraft, {0.0, 0.0}, -1) > 0.0);
}

TEST_CASE(
    "flight: without noise the autopilot reports the truth, and flies crabbed into the wind") {
  FlightOptions options;
  options.noise_scale = 0.0;
  for (const FlightPattern pattern : {FlightPattern::kLawnmower, FlightPattern::kSurvey}) {
    options.pattern = pattern;
    const auto exposures = PlanFlight(options, {4.0, 0.0});
    REQUIRE(exposures.size() == 72);
    int64_t previous_us = 0;
    for (const SyntheticExposure& exposure : exposures) {
      CHECK(exposure.timestamp_us > previous_us);
      previous_us = exposure.timestamp_us;
      CHECK((exposure.truth.position_in_world - exposure.reported.position_in_world).norm() == 0.0);
    }
  }
  options.pattern = FlightPattern::kLawnmower;
  // Northbound in a wind that blows east at 4 of 13 m/s: the nose points 17.9 deg left of north.
  const auto exposures = PlanFlight(options, {4.0, 0.0});
  CHECK(DegFromRad(exposures.front().truth.attitude.yaw) == doctest::Approx(-17.92).epsilon(0.01));
}

TEST_CASE("flight: the autopilot's errors have the spread that the options state") {
  FlightOptions options;
  options.num_frames = 4000;
  options.frame_period_s = 10.0;
  double sum_tilt = 0.0, sum_east = 0.0, sum_up = 0.0, sum_yaw = 0.0;
  const auto exposures = PlanFlight(options, {2.0, 1.0});
  for (const SyntheticExposure& exposure : exposures) {
    const Eigen::Vector3d error =
        exposure.reported.position_in_world - exposure.truth.position_in_world;
    sum_east += error.x() * error.x();
    sum_up += error.z();
    sum_tilt += std::pow(exposure.reported.attitude.roll - exposure.truth.attitude.roll, 2);
    sum_yaw += std::pow(WrapAngle(exposure.reported.attitude.yaw - exposure.truth.attitude.yaw), 2);
  }
  const double n = static_cast<double>(exposures.size());
  constexpr double kRelativeTolerance = 0.15;
  CHECK(std::sqrt(sum_east / n) ==
        doctest::Approx(std::hypot(0.5, 1.5)).epsilon(kRelativeTolerance));
  CHECK(std::abs(sum_up / n) == doctest::Approx(3.0).epsilon(kRelativeTolerance));
  CHECK(DegFromRad(std::sqrt(sum_tilt / n)) == doctest::Approx(1.0).epsilon(kRelativeTolerance));
  CHECK(DegFromRad(std::sqrt(sum_yaw / n)) == doctest::Approx(2.0).epsilon(kRelativeTolerance));
}

TEST_CASE("world and flight: Check names field, value and constraint") {
  WorldOptions world;
  world.size_m = 0.0;
  CHECK_THROWS_WITH_AS(
      world.Check(), "world.size_m = 0: must be in [20, 2000]", std::invalid_argument);
  FlightOptions flight;
  flight.num_frames = 0;
  CHECK_THROWS_WITH_AS(
      flight.Check(), "flight.num_frames = 0: must be in [1, 100000]", std::invalid_argument);
}

TEST_CASE("things: none of them is landable ground, however small") {
  const Aircraft aircraft = AircraftProfile("small").value();
  World world = MakeMeadowPlane(SmallWorld(200.0, 0.25));
  world.Put(Block{.center = {-40.0, 0.0}, .length_m = 2.1, .width_m = 0.8, .height_m = 1.4});
  world.Put(Boulder{.center = {-20.0, 0.0}});
  world.Dig(Ditch{.start = {0.0, -20.0}, .end = {0.0, 20.0}});
  world.Build(Fence{.start = {20.0, -20.0}, .end = {20.0, 20.0}});
  world.Plant(Tree{.center = {40.0, 0.0}, .is_leafless = true});
  for (const double x : {-40.0, -20.0, 0.0, 20.0, 40.0}) {
    CHECK(GroundFaultAt(world, aircraft, x, 0.0, 1.0) == GroundFault::kCover);
    CHECK(GroundFaultAt(world, aircraft, x + 10.0, 0.0, 1.0) == GroundFault::kNone);
  }
  CHECK(world.SurfaceHeight(-40.0, 0.0) == doctest::Approx(1.4));
  CHECK(world.SurfaceHeight(0.0, 0.0) < -0.5);
}

}  // namespace
}  // namespace freelsd
