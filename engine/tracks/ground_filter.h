// Height of the ground below the aircraft, carried along the flight.
#pragma once

#include <optional>

#include <Eigen/Core>

#include "engine/tracks/coarse_depth.h"

namespace freelsd {

// Scalar Kalman filter of the ground's world z: terrain rises and falls with distance flown.
class GroundFilter {
 public:
  // The aircraft is here now: the ground may have changed since.
  void MoveTo(const Eigen::Vector3d& position_in_world);
  void Update(const GroundHeight& measured);
  // The ground below is known.
  void Restart(const Eigen::Vector3d& position_in_world, double ground_height);
  std::optional<double> Height() const { return height_; }
  double Sd() const;

 private:
  std::optional<double> height_;
  double variance_ = 0.0;
  std::optional<Eigen::Vector2d> place_;
};

}  // namespace freelsd
