#include "tests/bench/bench_scene.h"

#include <stdexcept>

#include "tests/synthetic/flight_files.h"
#include "tests/synthetic/flight_plan.h"
#include "tests/synthetic/renderer.h"

namespace freelsd {
namespace {

constexpr int kNumFrames = 12;

Frame MakeFrame(const SyntheticExposure& exposure, const cv::Mat& image) {
  Frame frame;
  frame.id = exposure.image;
  frame.timestamp_us = exposure.timestamp_us;
  frame.image = image;
  frame.prior.position_in_world = exposure.reported.position_in_world;
  frame.prior.world_from_body = WorldFromBody(exposure.reported).rotation;
  frame.wind_in_world = exposure.reported_wind_in_world;
  return frame;
}

BenchScene MakeScene(const std::string& model_file) {
  WorldOptions world_options;
  world_options.size_m = 400.0;
  world_options.cell_size_m = 0.2;
  const auto made = std::make_shared<const World>(MakeFarmland(world_options));
  const World& world = *made;
  FlightOptions flight;
  flight.num_frames = kNumFrames;
  flight.height_above_origin_m = kBenchHeightM;
  BenchScene scene;
  scene.world = made;
  scene.rig.camera = PaperCamera(752, 480);
  const Renderer renderer(world);
  int index = 0;
  for (const SyntheticExposure& exposure : PlanFlight(flight, world.wind_in_world)) {
    const Rigid3d world_from_camera = WorldFromBody(exposure.truth) * scene.rig.body_from_camera;
    scene.frames.push_back(MakeFrame(
        exposure, renderer.Render(scene.rig.camera, world_from_camera, RenderOptions{}, index++)));
  }
  Frontend frontend(scene.rig, scene.options, ReadGroundModel(model_file).model);
  for (const Frame& frame : scene.frames) frontend.Process(frame);
  frontend.Flush();
  scene.snapshot = frontend.TakeSnapshot();
  scene.block = AdjustPoses(scene.snapshot.views, scene.rig.camera, scene.options.adjustment);
  const std::vector<StereoPair> pairs = SelectPairs(scene.block, scene.options.stereo);
  if (pairs.empty()) throw std::runtime_error("the flight to measure on has no stereo pair");
  scene.pair = pairs[pairs.size() / 2];
  return scene;
}

}  // namespace

const BenchScene& Scene(const std::string& model_file) {
  static const BenchScene kScene = MakeScene(model_file);
  return kScene;
}

std::string SizeOf(const cv::Mat& image) {
  return std::to_string(image.cols) + "x" + std::to_string(image.rows);
}

}  // namespace freelsd
