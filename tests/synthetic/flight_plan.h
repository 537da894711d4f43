// Input: a world's wind and a pattern. Output: where the aircraft truly was at each exposure, and
// what its noisy autopilot said.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/geometry/geometry.h"

namespace freelsd {

enum class FlightPattern {
  kLawnmower,  // parallel legs north and south, images dense enough to track
  kSurvey,     // parallel legs, photographs with about 65 % overlap
};

struct FlightOptions {
  uint64_t seed = 1;
  FlightPattern pattern = FlightPattern::kLawnmower;
  int num_frames = 72;
  double height_above_origin_m = 100.0;
  double airspeed_mps = 13.0;
  double frame_period_s = 1.0;
  double leg_spacing_m = 60.0;
  int64_t start_us = 1'717'236'000'000'000;  // 2024-06-01 10:00 UTC
  // --- What the autopilot gets wrong; noise_scale multiplies all of it ---
  double noise_scale = 1.0;
  double position_white_m = 0.5;
  double position_drift_m = 1.5;
  double drift_time_s = 30.0;
  double altitude_bias_m = 3.0;
  double roll_pitch_deg = 1.0;
  double yaw_drift_deg = 2.0;
  double wind_mps = 0.5;

  // Throws std::invalid_argument: "flight.num_frames = 0: must be in [1, 100000]".
  void Check() const;
};

struct AutopilotSample {
  Eigen::Vector3d position_in_world = Eigen::Vector3d::Zero();
  EulerAngles attitude;  // radians
};

struct SyntheticExposure {
  std::string image;  // file name
  int64_t timestamp_us = 0;
  AutopilotSample truth;
  AutopilotSample reported;
  Eigen::Vector2d reported_wind_in_world = Eigen::Vector2d::Zero();
};

// The aircraft flies crabbed through the wind: the heading is not the track.
std::vector<SyntheticExposure> PlanFlight(const FlightOptions& options,
                                          const Eigen::Vector2d& wind_in_world);

Rigid3d WorldFromBody(const AutopilotSample& sample);

}  // namespace freelsd
