// Height of the ground below the aircraft, tracked along the flight.
#pragma once

#include <optional>

#include <Eigen/Core>

#include "engine/tracks/coarse_depth.h"

namespace freelsd {

// Scalar Kalman filter of the ground's world z. Its uncertainty grows with distance flown.
class GroundFilter {
 public:
  // Predicts: the ground may have changed on the way here.
  void MoveTo(const Eigen::Vector3d& position_in_world);
  void Update(const GroundHeight& measured);
  // Sets a known ground height below the position.
  void Restart(const Eigen::Vector3d& position_in_world, double ground_height);
  std::optional<double> Height() const { return height_; }
  double Sd() const;

 private:
  std::optional<double> height_;
  double variance_ = 0.0;
  std::optional<Eigen::Vector2d> place_;
};

}  // namespace freelsd
