#include "tests/evaluation/synthetic_flight.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "tests/synthetic/conditions/conditions.h"
#include "tests/synthetic/flight_files.h"
#include "tests/synthetic/ground/real_ground.h"
#include "tests/synthetic/noise.h"
#include "tests/synthetic/renderer.h"
#include "tests/synthetic/texture/texture.h"

namespace freelsd {
namespace {

constexpr uint64_t kWindPurpose = 501;
constexpr uint64_t kDamagePurpose = 502;
constexpr uint64_t kTurnRatePurpose = 503;
constexpr uint64_t kSpacingPurpose = 504;
constexpr int kMaxNumFrames = 300;
// Real ground rises: the aircraft stays this far above all that it flies over.
constexpr double kLeastHeightM = 60.0;
// From the middle of the world to the ends of the legs, and a bit.
constexpr double kFlownReachM = 170.0;
// Views of a place from which it can be known: a pair, and one to check it by.
constexpr int kMinNumViews = 3;
constexpr double kMaxWindMps = 6.0;
constexpr double kMinWindMps = 1.0;

// As a camera stores it: compressed.
cv::Mat Compressed(const cv::Mat& image, int jpeg_quality) {
  std::vector<uchar> bytes;
  cv::imencode(".jpg", image, bytes, {cv::IMWRITE_JPEG_QUALITY, jpeg_quality});
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
  const double spacing_m = SpacingFor(seed, options);
  flight.num_frames = options.num_frames.value_or(NumFramesAt(spacing_m));
  flight.height_above_origin_m = options.height_m;
  flight.leg_spacing_m = options.leg_spacing_m;
  flight.frame_period_s = spacing_m / flight.airspeed_mps;
  flight.noise_scale = options.noise_scale;
  return flight;
}

struct PackWindow {
  std::string pack;
  GroundWindow window;
};

// The packs of a pool in turns, window by window. Two seeds in a row, which differ in their
// aircraft, share a window.
PackWindow ChooseGround(uint64_t seed, const std::string& ground) {
  std::vector<std::string> packs{ground};
  for (const Pool pool : {Pool::kTuning, Pool::kReport}) {
    if (ground == NameOf(pool)) packs = EvaluationPools().NamesOf("ground", pool);
  }
  std::vector<PackWindow> all;
  for (const std::string& pack : packs) {
    for (const GroundWindow& window : ReadGroundWindows(pack)) all.push_back({pack, window});
  }
  return all[seed / 2 % all.size()];
}

World MakeGround(const PackWindow& choice, const WorldOptions& options) {
  const double reach_m = options.size_m;  // the place is turned and moved
  return MakeWorldAround(Cut(ReadRealGround(choice.pack), choice.window, reach_m, kFlownReachM),
                         PlacementFor(options.seed),
                         options);
}

// Within reach of the flight, metres above the middle.
double HighestFlownOver(const World& world) {
  double highest = 0.0;
  for (double y = -kFlownReachM; y <= kFlownReachM; y += 1.0) {
    for (double x = -kFlownReachM; x <= kFlownReachM; x += 1.0) {
      highest = std::max(highest, world.SurfaceHeight(x, y));
    }
  }
  return highest;
}

// At the same altitude.
GeoPoint PlaceFrom(const GeoPoint& origin, double east_m, double north_m) {
  if (east_m == 0.0 && north_m == 0.0) return origin;
  GeoPoint place = LocalFrame(origin).GeoFromWorld({east_m, north_m, 0.0});
  place.altitude_m = origin.altitude_m;
  return place;
}

void MakeWorld(uint64_t seed, const ScenarioOptions& options, Scenario& scenario) {
  WorldOptions world_options;
  world_options.seed = seed;
  world_options.size_m = options.world_size_m;
  world_options.cell_size_m = options.cell_size_m;
  world_options.origin = PlaceFrom(world_options.origin, options.east_m, options.north_m);
  world_options.wind_speed_mps = Uniform(seed, kWindPurpose, kMinWindMps, kMaxWindMps);
  if (options.ground.empty()) {
    scenario.world = MakeCountryside(world_options);
  } else {
    const PackWindow choice = ChooseGround(seed, options.ground);
    scenario.ground = choice.pack + "/" + choice.window.name;
    scenario.world = MakeGround(choice, world_options);
  }
  if (options.texture == "recorded") {
    const std::optional<Pool> pool = EvaluationPools().OfSeed(seed);
    Clothe(scenario.world, Wardrobe::Read(NameOf(pool.value()), options.cell_size_m));
  }
}

Conditions ConditionsFor(uint64_t seed, const ScenarioOptions& options) {
  return options.conditions == "recorded" ? RecordedConditions(seed) : PlainConditions(seed);
}

// At an exposure: the wind carries the aircraft, gusts turn it.
CameraMotion MotionAt(const Scenario& scenario,
                      size_t index,
                      double turn_rate_deg_s,
                      uint64_t seed) {
  const AutopilotSample& truth = scenario.exposures[index].truth;
  CameraMotion motion;
  motion.velocity_in_world.head<2>() =
      FlightOptions().airspeed_mps * DirectionOf(truth.attitude.yaw) + scenario.world.wind_in_world;
  for (int axis = 0; axis < 3; ++axis) {
    const uint64_t purpose = MixSeed(kTurnRatePurpose, 3 * index + static_cast<uint64_t>(axis));
    // Evenly drawn with this deviation.
    motion.turn_rate_in_camera[axis] =
        std::sqrt(3.0) * RadFromDeg(turn_rate_deg_s) * Uniform(seed, purpose, -1.0, 1.0);
  }
  return motion;
}

std::string ProfileFor(uint64_t seed, const ScenarioOptions& options) {
  if (options.aircraft != "both") return options.aircraft;
  return seed % 2 == 0 ? "small" : "techpod";
}

}  // namespace

void ScenarioOptions::Check() const {
  if (num_frames && (*num_frames < 3 || *num_frames > kMaxNumFrames)) {
    throw std::invalid_argument("scenario.num_frames = " + std::to_string(*num_frames) +
                                ": must be in [3, 300]");
  }
  if (frame_spacing_m && !(*frame_spacing_m >= 3.0 && *frame_spacing_m <= 100.0)) {
    throw std::invalid_argument("scenario.frame_spacing_m = " + std::to_string(*frame_spacing_m) +
                                ": must be in [3, 100]");
  }
  if (!(damaged_ratio >= 0.0 && damaged_ratio <= 1.0)) {
    throw std::invalid_argument("scenario.damaged_ratio = " + std::to_string(damaged_ratio) +
                                ": must be in [0, 1]");
  }
  if (texture != "painted" && texture != "recorded") {
    throw std::invalid_argument("scenario.texture = " + texture + ": must be painted or recorded");
  }
  if (conditions != "plain" && conditions != "recorded") {
    throw std::invalid_argument("scenario.conditions = " + conditions +
                                ": must be plain or recorded");
  }
  if (aircraft != "both" && !AircraftProfile(aircraft)) {
    throw std::invalid_argument("scenario.aircraft = " + aircraft + ": must be both or a profile");
  }
}

double SpacingFor(uint64_t seed, const ScenarioOptions& options) {
  if (options.frame_spacing_m) return *options.frame_spacing_m;
  // Three seeds of each parity are flown at the three spacings, in an order of their own.
  constexpr size_t kNum = kSpacingsM.size();
  std::array<double, kNum> spacings = kSpacingsM;
  const uint64_t order = MixSeed(2 * (seed / (2 * kNum)) + seed % 2, kSpacingPurpose);
  std::swap(spacings[0], spacings[order % kNum]);
  std::swap(spacings[1], spacings[1 + order / kNum % (kNum - 1)]);
  return spacings[seed / 2 % kNum];
}

int NumFramesAt(double spacing_m) {
  // Metres of legs: a survey covers more.
  const double flown_m = spacing_m >= 20.0 ? 1500.0 : 936.0;
  return std::clamp(static_cast<int>(std::lround(flown_m / spacing_m)), 3, kMaxNumFrames);
}

Rigid3d Scenario::TrueWorldFromCamera(size_t exposure) const {
  return WorldFromBody(exposures[exposure].truth) * rig.body_from_camera;
}

const Pools& EvaluationPools() {
  static const Pools kPools = Pools::Read(FREELSD_SOURCE_DIR "/tests/evaluation/pools.csv");
  return kPools;
}

std::optional<std::string> FoldModelOf(const std::string& name) {
  const std::optional<int> fold = EvaluationPools().FoldOf(name);
  if (!fold) return std::nullopt;
  return FREELSD_SOURCE_DIR "/tests/evaluation/folds/fold" + std::to_string(*fold) + ".onnx";
}

Scenario MakeScenario(uint64_t seed,
                      const ScenarioOptions& options,
                      const std::function<void(double)>& progress) {
  options.Check();
  Scenario scenario;
  MakeWorld(seed, options, scenario);
  scenario.aircraft = *AircraftProfile(ProfileFor(seed, options));
  scenario.rig = PaperRig();
  scenario.frame_spacing_m = SpacingFor(seed, options);
  FlightOptions flight = FlightFor(seed, options);
  if (!options.ground.empty()) {
    flight.height_above_origin_m =
        std::max(options.height_m, HighestFlownOver(scenario.world) + kLeastHeightM);
  }
  scenario.exposures = PlanFlight(flight, scenario.world.wind_in_world);
  scenario.seen = SeenGround(scenario);
  progress(0.0);
  if (!options.takes_photographs) return scenario;
  const Conditions conditions = ConditionsFor(seed, options);
  if (options.conditions == "recorded") LightFor(conditions, scenario.world);
  for (size_t i = 0; i < scenario.exposures.size(); ++i) {
    const int64_t since_start_us =
        scenario.exposures[i].timestamp_us - scenario.exposures.front().timestamp_us;
    const World moment = scenario.world.At(1e-6 * static_cast<double>(since_start_us));
    cv::Mat image =
        Renderer(moment).Render(scenario.rig.camera,
                                scenario.TrueWorldFromCamera(i),
                                conditions.camera,
                                static_cast<int>(i),
                                MotionAt(scenario, i, conditions.turn_rate_deg_s, seed));
    if (i > 0 && IsDamaged(seed, i, options.damaged_ratio)) {
      image = Damaged(image, scenario.frames.back().image, i);
    }
    scenario.frames.push_back(
        MakeFrame(scenario.exposures[i], Compressed(image, conditions.jpeg_quality)));
    progress(static_cast<double>(i + 1) / static_cast<double>(scenario.exposures.size()));
  }
  return scenario;
}

}  // namespace freelsd
