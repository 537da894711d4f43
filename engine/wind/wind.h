// Input: wind measurements along the flight. Output: the wind at a place. Paper: Sec. III-I.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

namespace freelsd {

struct WindOptions {
  // --- Behaviour ---
  // Measurements farther from the place than this are ignored. Paper: "within a radius".
  double radius_m = 300.0;
  // Measurements older than this, relative to the flight's newest image, are ignored.
  double max_age_s = 1800.0;
  // Weight of a new measurement in the moving average, (0, 1]. Paper: EWMA without a number.
  double smoothing = 0.1;

  void Check() const;
};

struct WindSample {
  Eigen::Vector3d position_in_world = Eigen::Vector3d::Zero();
  // Velocity of the air over ground, m/s.
  Eigen::Vector2d wind_in_world = Eigen::Vector2d::Zero();
  int64_t timestamp_us = 0;
};

struct WindEstimate {
  Eigen::Vector2d wind_in_world = Eigen::Vector2d::Zero();
  // Root mean square deviation of the samples from the estimate, per axis.
  double spread_mps = 0.0;
  int num_samples = 0;
  int64_t last_sample_us = 0;
};

// Samples that are at most max_age_s old at `now_us`.
std::vector<WindSample> RecentSamples(const std::vector<WindSample>& samples,
                                      int64_t now_us,
                                      const WindOptions& options);

// Exponentially weighted moving average of the samples within radius_m, oldest first. Nothing if
// there is no sample.
std::optional<WindEstimate> WindAt(const Eigen::Vector2d& place_in_world,
                                   const std::vector<WindSample>& samples,
                                   const WindOptions& options);

}  // namespace freelsd
