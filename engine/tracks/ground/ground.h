// Estimates the height of the ground below the aircraft along the flight.
#pragma once

#include <optional>

#include <Eigen/Core>

#include "engine/tracks/coarse_depth.h"

namespace freelsd {

// Scalar Kalman filter of the ground's world z. Its uncertainty grows with the distance flown.
class GroundFilter {
 public:
  // Prediction step: the ground's height may differ from that at the last position.
  void MoveTo(const Eigen::Vector3d& position_in_world);
  void Update(const GroundHeight& measured);
  // Sets the ground height below this position to a known value.
  void Restart(const Eigen::Vector3d& position_in_world, double ground_height);
  std::optional<double> Height() const { return height_; }
  double Sd() const;

 private:
  std::optional<double> height_;
  double variance_ = 0.0;
  std::optional<Eigen::Vector2d> place_;
};

}  // namespace freelsd
