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

// Logarithms of the factors of each layer, one per channel. Least squares; their mean is 0.
std::vector<cv::Vec4d> LogGains(size_t num_layers,
                                const std::vector<Comparison>& comparisons,
                                double gain_sd);

}  // namespace freelsd
