// Input: height errors of a map at places. Output: the plane that they have in common, and what is
// left without it.
//
// A plan counts heights from the touchdown, so an error that is the same everywhere harms nobody,
// and a tilt matters little. What is left is the error that hides things.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "tests/evaluation/statistics.h"

namespace freelsd {

struct HeightError {
  Eigen::Vector2d place = Eigen::Vector2d::Zero();
  // Estimate less truth, metres.
  double error = 0.0;
};

// Error of a map that is shifted upwards and tilted.
struct ErrorPlane {
  double offset = 0.0;
  Eigen::Vector2d gradient = Eigen::Vector2d::Zero();

  double At(const Eigen::Vector2d& place) const { return offset + gradient.dot(place); }
  double TiltDeg() const;
};

struct DetiltedErrors {
  ErrorPlane plane;
  // All errors less the plane, outliers included; metres.
  Sums residual;
  // Deviation of the residual within each window of 20 m, metres.
  LogHistogram local_noise;
};

// Least squares, then once more without what is more than three deviations away. A zero plane if
// there are too few errors for one.
ErrorPlane FitErrorPlane(const std::vector<HeightError>& errors);
DetiltedErrors Detilt(const std::vector<HeightError>& errors);

}  // namespace freelsd
