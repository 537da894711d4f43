// Private to ground_kind/. What a model consists of.
#pragma once

#include <array>
#include <string>

#include <opencv2/core.hpp>

#include "engine/ground_kind/ground_kind.h"

namespace freelsd {

constexpr int kNumColourStatistics = 5;
using ColourStatistics = cv::Vec<double, kNumColourStatistics>;

// Fields of ground_kind.json; training/README.md, "How the network is called".
struct KindModel::Content {
  std::string onnx;

  double metres_per_pixel = 0.2;
  int stride_px = 4;
  double offset = 0.0;
  double scale = 1.0;
  int multiple_of_px = 16;
  int border_px = 24;
  double dark_luma = 0.0;
  double brightened_luma = 0.0;
  double largest_gain = 1.0;

  ColourStatistics mean_colours;
  cv::Matx<double, kNumColourStatistics, kNumColourStatistics> inverse_covariance;
  double largest_distance = 0.0;

  double platt_scale = 1.0;
  double platt_shift = 0.0;
  double largest_probability = 1.0;
};

}  // namespace freelsd
