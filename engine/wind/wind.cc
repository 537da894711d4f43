#include "engine/wind/wind.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace freelsd {

void WindOptions::Check() const {
  if (!(radius_m > 0.0)) {
    throw std::invalid_argument("wind.radius_m = " + std::to_string(radius_m) +
                                ": must be positive");
  }
  if (!(smoothing > 0.0 && smoothing <= 1.0)) {
    throw std::invalid_argument("wind.smoothing = " + std::to_string(smoothing) +
                                ": must be in (0, 1]");
  }
}

std::optional<WindEstimate> WindAt(const Eigen::Vector2d& place_in_world,
                                   const std::vector<WindSample>& samples,
                                   const WindOptions& options) {
  std::vector<WindSample> near;
  for (const WindSample& sample : samples) {
    const double distance = (sample.position_in_world.head<2>() - place_in_world).norm();
    if (distance <= options.radius_m) near.push_back(sample);
  }
  if (near.empty()) return std::nullopt;
  std::stable_sort(near.begin(), near.end(), [](const WindSample& a, const WindSample& b) {
    return a.timestamp_us < b.timestamp_us;
  });
  WindEstimate estimate;
  estimate.wind_in_world = near.front().wind_in_world;
  double variance = 0.0;
  for (size_t i = 1; i < near.size(); ++i) {
    // Vectors are averaged, never angles: 350 and 10 degrees would give 180.
    const Eigen::Vector2d difference = near[i].wind_in_world - estimate.wind_in_world;
    estimate.wind_in_world += options.smoothing * difference;
    variance =
        (1.0 - options.smoothing) * (variance + options.smoothing * 0.5 * difference.squaredNorm());
  }
  estimate.spread_mps = std::sqrt(variance);
  estimate.num_samples = static_cast<int>(near.size());
  estimate.last_sample_us = near.back().timestamp_us;
  return estimate;
}

}  // namespace freelsd
