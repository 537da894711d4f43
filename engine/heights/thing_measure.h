// Private to heights/. Compares, sample by sample, the heights above the ground with the ground's.
#pragma once

#include <vector>

#include <opencv2/core.hpp>

namespace freelsd {

// By sample; metres above the proposal surface.
struct SampleHeights {
  cv::Mat1f ground;
  // What pairs propose to stand there; NaN for nothing.
  cv::Mat1f proposed;
};

// Least variances of the views, by sample; infinity where no such height was tried.
struct ThingVariances {
  cv::Mat1f on_ground, above, at_proposed;
  // Of `above`.
  cv::Mat1f above_height;
};

// `variance`: by height, of thing_window_m.
ThingVariances CompareHeights(const std::vector<cv::Mat1f>& variance,
                              const std::vector<double>& heights,
                              const SampleHeights& at,
                              double min_thing_height_m);

// Of the samples of one cell.
struct ThingMeasure {
  // Largest variance at the ground's height.
  float worst_variance = 0.0f;
  // Largest logarithm of the variance at the ground's height over that above it, and where; and
  // over that at the proposed height.
  float gain = 0.0f, gain_height = 0.0f, proposed_gain = 0.0f;
};

ThingMeasure MeasureThing(const ThingVariances& variances, const cv::Rect& samples);

// Variance of log brightness that any camera has: keeps ratios finite.
constexpr float kLeastVariance = 1e-5f;

}  // namespace freelsd
