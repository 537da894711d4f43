#include "tests/synthetic/sensor.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "tests/synthetic/noise.h"

namespace freelsd {
namespace {

constexpr uint64_t kSensorPurpose = 401;
constexpr uint64_t kExposurePurpose = 402;
constexpr uint64_t kStepPurpose = 404;
// A camera keeps an exposure for so many photographs.
constexpr int kFramesPerStep = 7;
// What haze looks like, BGR.
const cv::Vec3f kAirLight(205.0f, 200.0f, 192.0f);
// The sensor's noise is picked from so many values that were drawn once: a power of two.
constexpr uint64_t kNumDraws = 16384;
constexpr int kDrawBits = 14;
constexpr uint64_t kDrawSeed = 21;

// Normally distributed, mean 0, standard deviation 1.
const std::vector<float>& Draws() {
  static const std::vector<float> kDraws = [] {
    std::vector<float> values(kNumDraws);
    std::mt19937_64 random(kDrawSeed);
    std::normal_distribution<float> normal;
    for (float& value : values) value = normal(random);
    return values;
  }();
  return kDraws;
}

double Exposure(const RenderOptions& options, int frame_index) {
  const Noise slow(MixSeed(options.seed, kExposurePurpose), 15.0);
  const double wander = std::clamp(0.5 * slow.At(frame_index, 0.0), -1.0, 1.0);
  const uint64_t step = MixSeed(options.seed, static_cast<uint64_t>(frame_index / kFramesPerStep));
  return (1.0 + options.exposure_drift_ratio * wander) *
         (1.0 + options.exposure_step_ratio * Uniform(step, kStepPurpose, -1.0, 1.0));
}

}  // namespace

cv::Mat Expose(const cv::Mat3f& light, const RenderOptions& options, int frame_index) {
  cv::Mat3f blurred = light;
  if (options.lens_blur_px > 0.0) {
    cv::GaussianBlur(
        light, blurred, {}, options.lens_blur_px, options.lens_blur_px, cv::BORDER_REPLICATE);
  }
  const double exposure = Exposure(options, frame_index);
  const double cx = 0.5 * (light.cols - 1), cy = 0.5 * (light.rows - 1);
  const double corner = cx * cx + cy * cy;
  const float sensor_noise = static_cast<float>(options.sensor_noise);
  const float haze = static_cast<float>(options.haze_ratio);
  const float* draws = Draws().data();
  const uint64_t stream = MixSeed(MixSeed(options.seed, kSensorPurpose), frame_index);
  cv::Mat3b image(light.size());
  for (int row = 0; row < light.rows; ++row) {
    for (int col = 0; col < light.cols; ++col) {
      const double radius = ((col - cx) * (col - cx) + (row - cy) * (row - cy)) / corner;
      const float gain = static_cast<float>(exposure * (1.0 - options.vignetting_ratio * radius));
      uint64_t bits = MixSeed(stream,
                              static_cast<uint64_t>(row) * static_cast<uint64_t>(light.cols) +
                                  static_cast<uint64_t>(col));
      const cv::Vec3f color = (1.0f - haze) * blurred(row, col) + haze * kAirLight;
      for (int i = 0; i < 3; ++i) {
        const float noise = sensor_noise * draws[bits % kNumDraws];
        const float signal = gain * options.color_gain[i] * color[i];
        image(row, col)[i] = cv::saturate_cast<uint8_t>(signal + noise);
        bits >>= kDrawBits;
      }
    }
  }
  return image;
}

}  // namespace freelsd
