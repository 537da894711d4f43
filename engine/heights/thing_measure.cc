#include "engine/heights/thing_measure.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace freelsd {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
// Heights within this of the ground's peak are the ground: tufts, and the peak's own width.
constexpr float kGroundReliefM = 0.25f;
// The pairs' upper height is a percentile of noisy points.
constexpr float kProposedReliefM = 0.35f;

struct RowOfHeights {
  const float* ground;
  const float* proposed;
  float* on_ground;
  float* above;
  float* above_height;
  float* at_proposed;
};

void CompareRow(
    const float* variance, float height, float min_thing_height, int count, RowOfHeights row) {
  for (int i = 0; i < count; ++i) {
    const float over_ground = height - row.ground[i];
    const bool is_ground = std::abs(over_ground) <= kGroundReliefM;
    const bool is_better = over_ground >= min_thing_height && variance[i] < row.above[i];
    const bool is_proposed = std::abs(height - row.proposed[i]) <= kProposedReliefM;
    row.on_ground[i] = is_ground ? std::min(row.on_ground[i], variance[i]) : row.on_ground[i];
    row.above_height[i] = is_better ? height : row.above_height[i];
    row.above[i] = is_better ? variance[i] : row.above[i];
    row.at_proposed[i] =
        is_proposed ? std::min(row.at_proposed[i], variance[i]) : row.at_proposed[i];
  }
}

float Gain(float on_ground, float elsewhere) {
  if (!std::isfinite(on_ground) || !std::isfinite(elsewhere)) return 0.0f;
  return std::log((on_ground + kLeastVariance) / (elsewhere + kLeastVariance));
}

}  // namespace

ThingVariances CompareHeights(const std::vector<cv::Mat1f>& variance,
                              const std::vector<double>& heights,
                              const SampleHeights& at,
                              double min_thing_height_m) {
  const cv::Size size = at.ground.size();
  ThingVariances least{cv::Mat1f(size, kInfinity),
                       cv::Mat1f(size, kInfinity),
                       cv::Mat1f(size, kInfinity),
                       at.ground.clone()};
  for (int row = 0; row < size.height; ++row) {
    for (size_t h = 0; h < heights.size(); ++h) {
      CompareRow(variance[h][row],
                 static_cast<float>(heights[h]),
                 static_cast<float>(min_thing_height_m),
                 size.width,
                 {at.ground[row],
                  at.proposed[row],
                  least.on_ground[row],
                  least.above[row],
                  least.above_height[row],
                  least.at_proposed[row]});
    }
  }
  return least;
}

ThingMeasure MeasureThing(const ThingVariances& variances, const cv::Rect& samples) {
  ThingMeasure measure;
  for (int row = samples.y; row < samples.y + samples.height; ++row) {
    for (int col = samples.x; col < samples.x + samples.width; ++col) {
      const float on_ground = variances.on_ground(row, col);
      if (!std::isfinite(on_ground)) continue;
      measure.worst_variance = std::max(measure.worst_variance, on_ground);
      measure.proposed_gain =
          std::max(measure.proposed_gain, Gain(on_ground, variances.at_proposed(row, col)));
      const float gain = Gain(on_ground, variances.above(row, col));
      if (gain <= measure.gain) continue;
      measure.gain = gain;
      measure.gain_height = variances.above_height(row, col);
    }
  }
  return measure;
}

}  // namespace freelsd
