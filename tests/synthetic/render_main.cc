// freelsd-render: a sample flight over a made-up countryside, as files that curl can submit.
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <stdexcept>
#include <string>

#include <CLI/CLI.hpp>
#include <opencv2/imgcodecs.hpp>
#include <unistd.h>

#include "tests/synthetic/flight_files.h"
#include "tests/synthetic/renderer.h"

namespace freelsd {
namespace {

constexpr int kJpegQuality = 92;

struct Arguments {
  std::string folder;
  uint64_t seed = 1;
  int num_frames = 72;
  int width_px = 752;
  int height_px = 480;
  std::string pattern = "lawnmower";
  std::string aircraft = "small";
  double noise_scale = 1.0;
  double wind_speed_mps = 4.0;
  double size_m = WorldOptions{}.size_m;
};

FlightPattern PatternFrom(const std::string& name) {
  if (name == "survey") return FlightPattern::kSurvey;
  return FlightPattern::kLawnmower;
}

void Write(const std::filesystem::path& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text;
  file.flush();
  if (!file) throw std::runtime_error("cannot write " + path.string());
}

void ShowProgress(int done, int total) {
  const bool is_terminal = isatty(STDOUT_FILENO) != 0;
  if (is_terminal) {
    std::cout << "\rrendered " << done << " of " << total << " frames" << std::flush;
    if (done == total) std::cout << "\n";
  } else if (done % 20 == 0 || done == total) {
    std::cout << "rendered " << done << " of " << total << " frames" << std::endl;
  }
}

void RenderFrames(const World& world,
                  const Camera& camera,
                  const std::vector<SyntheticExposure>& exposures,
                  const std::filesystem::path& folder) {
  const Renderer renderer(world);
  RenderOptions options;
  options.seed = world.seed;
  const Rigid3d body_from_camera = Rig{}.body_from_camera;
  const int total = static_cast<int>(exposures.size());
  for (int i = 0; i < total; ++i) {
    const SyntheticExposure& exposure = exposures[static_cast<size_t>(i)];
    const Rigid3d world_from_camera = WorldFromBody(exposure.truth) * body_from_camera;
    const cv::Mat image = renderer.Render(camera, world_from_camera, options, i);
    const std::string path = (folder / exposure.image).string();
    if (!cv::imwrite(path, image, {cv::IMWRITE_JPEG_QUALITY, kJpegQuality})) {
      throw std::runtime_error("cannot write " + path);
    }
    ShowProgress(i + 1, total);
  }
}

void Run(const Arguments& arguments) {
  const auto aircraft = AircraftProfile(arguments.aircraft);
  if (!aircraft) throw std::invalid_argument("--aircraft " + arguments.aircraft + " is unknown");
  WorldOptions world_options;
  world_options.seed = arguments.seed;
  world_options.wind_speed_mps = arguments.wind_speed_mps;
  world_options.size_m = arguments.size_m;
  FlightOptions flight_options;
  flight_options.seed = arguments.seed;
  flight_options.num_frames = arguments.num_frames;
  flight_options.pattern = PatternFrom(arguments.pattern);
  flight_options.noise_scale = arguments.noise_scale;
  flight_options.Check();
  const Camera camera = PaperCamera(arguments.width_px, arguments.height_px);
  camera.Check();

  const std::filesystem::path folder = arguments.folder;
  std::filesystem::create_directories(folder);
  std::cout << "making world " << arguments.seed << std::endl;
  const World world = MakeFarmland(world_options);
  const auto exposures = PlanFlight(flight_options, world.wind_in_world);
  Write(folder / "poses.csv", PosesCsv(world, exposures));
  Write(folder / "flight.json",
        FlightJson("Sample flight " + std::to_string(arguments.seed), camera, aircraft->profile));
  RenderFrames(world, camera, exposures, folder);
}

}  // namespace
}  // namespace freelsd

int main(int argc, char** argv) {
  try {
    freelsd::Arguments arguments;
    CLI::App app(
        "Renders a flight over a synthetic world: photographs, poses.csv and flight.json.");
    app.add_option("--out", arguments.folder, "folder to write to")->required();
    app.add_option("--seed", arguments.seed, "chooses world and flight");
    app.add_option("--frames", arguments.num_frames, "number of photographs")
        ->check(CLI::Range(1, 10000));
    app.add_option("--width", arguments.width_px, "image width in pixels")
        ->check(CLI::Range(16, 8192));
    app.add_option("--height", arguments.height_px, "image height in pixels")
        ->check(CLI::Range(16, 8192));
    app.add_option("--pattern", arguments.pattern, "how the area is flown")
        ->check(CLI::IsMember({"lawnmower", "survey"}));
    app.add_option("--aircraft", arguments.aircraft, "profile for flight.json")
        ->check(CLI::IsMember({"techpod", "atlantiksolar", "small"}));
    app.add_option("--noise", arguments.noise_scale, "scale of the autopilot's errors")
        ->check(CLI::Range(0.0, 2.0));
    app.add_option("--wind", arguments.wind_speed_mps, "wind speed in m/s")
        ->check(CLI::Range(0.0, 9.0));
    app.add_option("--size", arguments.size_m, "side of the world in metres")
        ->check(CLI::Range(300.0, 2000.0));
    CLI11_PARSE(app, argc, argv);
    freelsd::Run(arguments);
  } catch (const std::exception& error) {
    std::cerr << "freelsd-render: " << error.what() << "\n";
    return 1;
  }
  return 0;
}
