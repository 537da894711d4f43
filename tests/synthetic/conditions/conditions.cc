#include "tests/synthetic/conditions/conditions.h"

#include <cmath>
#include <limits>

#include "tests/synthetic/noise.h"

namespace freelsd {
namespace {

// Purposes of randomness.
enum Purpose : uint64_t {
  kWeather = 721,
  kSunElevation,
  kExposureStep,
  kVignetting,
  kCast,
  kCastStrength,
  kHaze,
  kLensBlur,
  kShutter,
  kReadout,
  kQuality,
};

constexpr double kShareOfLowSun = 0.2;
constexpr double kShareOfClouds = 0.2;
// Under clouds the sun adds little: more than this and its tint would be negative.
constexpr double kCloudySkyShare = 0.8;
// The camera of one flight in ten has a magenta cast and is dark in the middle, as places/cmac_au.
constexpr double kShareOfCast = 0.1;
constexpr double kShareOfRollingShutter = 0.5;
constexpr double kShareOfCoarseFiles = 0.3;
constexpr int kCoarseQuality = 70;

}  // namespace

Conditions PlainConditions(uint64_t seed) {
  Conditions conditions;
  conditions.camera.seed = seed;
  conditions.sun_elevation_deg = std::numeric_limits<double>::quiet_NaN();
  return conditions;
}

Conditions RecordedConditions(uint64_t seed) {
  const auto uniform = [seed](Purpose purpose, double low, double high) {
    return Uniform(seed, purpose, low, high);
  };
  Conditions conditions = PlainConditions(seed);
  const double weather = uniform(kWeather, 0.0, 1.0);
  if (weather < kShareOfLowSun) {
    conditions.sun_elevation_deg = uniform(kSunElevation, 12.0, 25.0);
  } else if (weather < kShareOfLowSun + kShareOfClouds) {
    conditions.sky_share = kCloudySkyShare;
  }
  RenderOptions& camera = conditions.camera;
  camera.exposure_step_ratio = uniform(kExposureStep, 0.0, 0.13);
  camera.vignetting_ratio = uniform(kVignetting, -0.1, 0.2);
  // A camera's own white balance.
  for (int i = 0; i < 3; ++i) {
    camera.color_gain[i] =
        static_cast<float>(Uniform(MixSeed(seed, static_cast<uint64_t>(i)), kCast, 0.94, 1.06));
  }
  if (uniform(kCastStrength, 0.0, 1.0) < kShareOfCast) {
    camera.color_gain = {1.05f, 0.72f, 1.05f};
    camera.vignetting_ratio = -0.16;
    camera.exposure_step_ratio = 0.5;
  }
  camera.haze_ratio = uniform(kHaze, 0.0, 0.06);
  camera.lens_blur_px = uniform(kLensBlur, 0.4, 0.9);
  camera.exposure_s = uniform(kShutter, 1.0 / 1000.0, 1.0 / 250.0);
  conditions.turn_rate_deg_s = 3.0;
  const double readout = uniform(kReadout, 0.0, 1.0);
  if (readout < kShareOfRollingShutter) camera.readout_s = 0.02 + 0.04 * readout;
  if (uniform(kQuality, 0.0, 1.0) < kShareOfCoarseFiles) conditions.jpeg_quality = kCoarseQuality;
  return conditions;
}

void LightFor(const Conditions& conditions, World& world) {
  world.sky_share = conditions.sky_share;
  if (!std::isnan(conditions.sun_elevation_deg)) {
    const double elevation = RadFromDeg(conditions.sun_elevation_deg);
    world.sun_in_world << std::cos(elevation) * world.sun_in_world.head<2>().normalized(),
        std::sin(elevation);
  }
  world.Light();
}

}  // namespace freelsd
