// Gains that make views alike where they overlap.
#pragma once

#include <vector>

#include <opencv2/core.hpp>

#include "engine/mosaic/view_layer.h"

namespace freelsd {

// Values of two layers where both show the ground.
struct Comparison {
  size_t first = 0;
  size_t second = 0;
  // Medians of log(value of second) - log(value of first): blue, green, red, detail.
  cv::Vec4d log_ratio;
  int num_cells = 0;
};

std::vector<Comparison> Compare(const std::vector<ViewLayer>& layers);

// Factors of one layer's colours. Besides its gain, they remove a trend that all layers have in
// common: towards the sun, ground looks darker than away from it. From view to view, this looks
// like a small step of the gain, and the sum of many such steps would make one end of a long flight
// black and the other white.
struct Tone {
  // Blue, green, red, and detail; the last has no trend.
  cv::Vec4d log_gain;
  // Logarithm per metre east and north of the camera.
  cv::Vec3d east, north;
  Eigen::Vector2d camera_in_world = Eigen::Vector2d::Zero();

  cv::Vec3d Gain() const;
  cv::Vec3f FactorAt(const Eigen::Vector2d& place_in_world) const;
};

// One per layer, by least squares. `cameras_in_world` has the layers' order. The mean of the
// logarithms is 0.
std::vector<Tone> Balance(const std::vector<Eigen::Vector2d>& cameras_in_world,
                          const std::vector<Comparison>& comparisons,
                          double gain_sd);

}  // namespace freelsd
