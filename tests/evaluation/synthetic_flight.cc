#include "tests/evaluation/synthetic_flight.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "tests/synthetic/flight_files.h"
#include "tests/synthetic/ground/real_ground.h"
#include "tests/synthetic/noise.h"
#include "tests/synthetic/renderer.h"

namespace freelsd {
namespace {

constexpr uint64_t kWindPurpose = 501;
constexpr uint64_t kDamagePurpose = 502;
constexpr int kJpegQuality = 92;
// Views of a place from which it can be known: a pair, and one to check it by.
constexpr int kMinNumViews = 3;
constexpr double kMaxWindMps = 6.0;
constexpr double kMinWindMps = 1.0;

// As a camera stores it: compressed.
cv::Mat Compressed(const cv::Mat& image) {
  std::vector<uchar> bytes;
  cv::imencode(".jpg", image, bytes, {cv::IMWRITE_JPEG_QUALITY, kJpegQuality});
  return cv::imdecode(bytes, cv::IMREAD_COLOR);
}

// What transmission, sun, vibration and mixed-up names do, in turns. `earlier` is the photograph
// before this one.
cv::Mat Damaged(const cv::Mat& image, const cv::Mat& earlier, size_t index) {
  constexpr double kBurntGain = 4.0;
  constexpr int kSmearPx = 41;
  cv::Mat damaged = image.clone();
  switch (index % 4) {
    case 0:
      damaged.rowRange(image.rows / 2, image.rows).setTo(0);
      break;
    case 1:
      damaged.convertTo(damaged, -1, kBurntGain);
      break;
    case 2:
      cv::blur(damaged, damaged, {kSmearPx, 1});
      break;
    default:
      earlier.copyTo(damaged);
  }
  return damaged;
}

// Which photographs, and how, depends on seed and number alone.
bool IsDamaged(uint64_t seed, size_t index, double ratio) {
  return Uniform(MixSeed(seed, index), kDamagePurpose, 0.0, 1.0) < ratio;
}

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

// Is a place of the world within the photograph? Things that stand before it are not asked.
bool IsInImage(const Camera& camera,
               const Rigid3d& camera_from_world,
               const Eigen::Vector3d& point_in_world) {
  const Eigen::Vector3d point_in_camera = camera_from_world * point_in_world;
  if (point_in_camera.z() <= 0.0) return false;
  const auto pixel = camera.ImageFromCamera(point_in_camera);
  return pixel && pixel->x() >= 0.0 && pixel->y() >= 0.0 && pixel->x() <= camera.width_px - 1.0 &&
         pixel->y() <= camera.height_px - 1.0;
}

cv::Mat1b SeenGround(const Scenario& scenario) {
  const int n = static_cast<int>(std::floor(scenario.world.size_m));
  const double half = 0.5 * scenario.world.size_m;
  cv::Mat1b num_views(n, n, static_cast<uint8_t>(0));
  for (size_t i = 0; i < scenario.exposures.size(); ++i) {
    const Rigid3d camera_from_world = Inverse(scenario.TrueWorldFromCamera(i));
    for (int row = 0; row < n; ++row) {
      for (int col = 0; col < n; ++col) {
        if (num_views(row, col) >= kMinNumViews) continue;
        const double x = col + 0.5 - half, y = row + 0.5 - half;
        const Eigen::Vector3d place(x, y, scenario.world.GroundHeight(x, y));
        num_views(row, col) += IsInImage(scenario.rig.camera, camera_from_world, place);
      }
    }
  }
  return num_views >= kMinNumViews;
}

FlightOptions FlightFor(uint64_t seed, const ScenarioOptions& options) {
  FlightOptions flight;
  flight.seed = seed;
  flight.pattern = options.pattern;
  flight.num_frames = options.num_frames;
  flight.height_above_origin_m = options.height_m;
  flight.leg_spacing_m = options.leg_spacing_m;
  flight.frame_period_s = options.frame_spacing_m / flight.airspeed_mps;
  flight.noise_scale = options.noise_scale;
  return flight;
}

World MakeWorld(uint64_t seed, const ScenarioOptions& options) {
  WorldOptions world_options;
  world_options.seed = seed;
  world_options.size_m = options.world_size_m;
  world_options.cell_size_m = options.cell_size_m;
  world_options.wind_speed_mps = Uniform(seed, kWindPurpose, kMinWindMps, kMaxWindMps);
  if (options.ground.empty()) return MakeCountryside(world_options);
  return MakeWorldAround(ReadRealGround(options.ground), PlacementFor(seed), world_options);
}

std::string ProfileFor(uint64_t seed, const ScenarioOptions& options) {
  if (options.aircraft != "both") return options.aircraft;
  return seed % 2 == 0 ? "small" : "techpod";
}

}  // namespace

void ScenarioOptions::Check() const {
  if (num_frames < 3 || num_frames > 300) {
    throw std::invalid_argument("scenario.num_frames = " + std::to_string(num_frames) +
                                ": must be in [3, 300]");
  }
  if (!(damaged_ratio >= 0.0 && damaged_ratio <= 1.0)) {
    throw std::invalid_argument("scenario.damaged_ratio = " + std::to_string(damaged_ratio) +
                                ": must be in [0, 1]");
  }
  if (aircraft != "both" && !AircraftProfile(aircraft)) {
    throw std::invalid_argument("scenario.aircraft = " + aircraft + ": must be both or a profile");
  }
}

Rigid3d Scenario::TrueWorldFromCamera(size_t exposure) const {
  return WorldFromBody(exposures[exposure].truth) * rig.body_from_camera;
}

Scenario MakeScenario(uint64_t seed,
                      const ScenarioOptions& options,
                      const std::function<void(double)>& progress) {
  options.Check();
  Scenario scenario;
  scenario.world = MakeWorld(seed, options);
  scenario.aircraft = *AircraftProfile(ProfileFor(seed, options));
  scenario.rig = SyntheticRig(options.camera);
  scenario.exposures = PlanFlight(FlightFor(seed, options), scenario.world.wind_in_world);
  scenario.seen = SeenGround(scenario);
  progress(0.0);
  if (!options.takes_photographs) return scenario;
  RenderOptions render_options;
  render_options.seed = seed;
  for (size_t i = 0; i < scenario.exposures.size(); ++i) {
    const int64_t since_start_us =
        scenario.exposures[i].timestamp_us - scenario.exposures.front().timestamp_us;
    const World moment = scenario.world.At(1e-6 * static_cast<double>(since_start_us));
    cv::Mat image = Renderer(moment).Render(
        scenario.rig.camera, scenario.TrueWorldFromCamera(i), render_options, static_cast<int>(i));
    if (i > 0 && IsDamaged(seed, i, options.damaged_ratio)) {
      image = Damaged(image, scenario.frames.back().image, i);
    }
    scenario.frames.push_back(MakeFrame(scenario.exposures[i], Compressed(image)));
    progress(static_cast<double>(i + 1) / static_cast<double>(scenario.exposures.size()));
  }
  return scenario;
}

}  // namespace freelsd
