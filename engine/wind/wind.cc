#include "engine/wind/wind.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <tuple>

#include "engine/check/check.h"

namespace freelsd {
namespace {

bool IsFinite(const WindSample& sample) {
  return sample.position_in_world.head<2>().allFinite() && sample.wind_in_world.allFinite();
}

// Oldest first. The order of samples with equal times does not depend on their arrival.
std::vector<WindSample> SamplesNear(const Eigen::Vector2d& place_in_world,
                                    const std::vector<WindSample>& samples,
                                    double radius) {
  std::vector<WindSample> near;
  for (const WindSample& sample : samples) {
    if (!IsFinite(sample)) continue;
    if ((sample.position_in_world.head<2>() - place_in_world).norm() > radius) continue;
    near.push_back(sample);
  }
  const auto key = [](const WindSample& sample) {
    return std::tuple(sample.timestamp_us, sample.wind_in_world.x(), sample.wind_in_world.y());
  };
  std::sort(
      near.begin(), near.end(), [&](const auto& a, const auto& b) { return key(a) < key(b); });
  return near;
}

}  // namespace

void WindOptions::Check() const {
  const FieldCheck check("wind");
  check.Require(std::isfinite(radius_m) && radius_m > 0.0,
                "radius_m",
                radius_m,
                "must be positive and finite");
  check.Require(std::isfinite(max_age_s) && max_age_s > 0.0,
                "max_age_s",
                max_age_s,
                "must be positive and finite");
  check.Require(smoothing > 0.0 && smoothing <= 1.0, "smoothing", smoothing, "must be in (0, 1]");
}

std::vector<WindSample> RecentSamples(const std::vector<WindSample>& samples,
                                      int64_t now_us,
                                      const WindOptions& options) {
  std::vector<WindSample> recent;
  std::copy_if(
      samples.begin(), samples.end(), std::back_inserter(recent), [&](const WindSample& sample) {
        return static_cast<double>(now_us - sample.timestamp_us) * 1e-6 <= options.max_age_s;
      });
  return recent;
}

std::optional<WindEstimate> WindAt(const Eigen::Vector2d& place_in_world,
                                   const std::vector<WindSample>& samples,
                                   const WindOptions& options) {
  const std::vector<WindSample> near = SamplesNear(place_in_world, samples, options.radius_m);
  if (near.empty()) return std::nullopt;
  WindEstimate estimate;
  estimate.wind_in_world = near.front().wind_in_world;
  for (const WindSample& sample : near) {
    estimate.wind_in_world += options.smoothing * (sample.wind_in_world - estimate.wind_in_world);
  }
  double squared_deviation = 0.0;
  for (const WindSample& sample : near) {
    squared_deviation += (sample.wind_in_world - estimate.wind_in_world).squaredNorm();
  }
  const auto num_samples = static_cast<double>(near.size());
  estimate.spread_mps = std::sqrt(0.5 * squared_deviation / num_samples);
  estimate.num_samples = static_cast<int>(near.size());
  estimate.last_sample_us = near.back().timestamp_us;
  return estimate;
}

}  // namespace freelsd
