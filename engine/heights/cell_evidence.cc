#include "engine/heights/cell_evidence.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
// Variance of log brightness that any camera has: keeps ratios finite.
constexpr float kLeastVariance = 1e-5f;
// Heights within this of the ground's peak are the ground: tufts, and the peak's own width.
constexpr double kGroundReliefM = 0.25;
// Samples of a window tell each other: neighbours share pixels.
constexpr double kIndependentShare = 0.5;

cv::Mat1f Box(const cv::Mat1f& values, int side) {
  cv::Mat1f mean;
  cv::boxFilter(values, mean, -1, {side, side}, {-1, -1}, true, cv::BORDER_REPLICATE);
  return mean;
}

// The measures of one tile, filtered.
struct FilteredTile {
  // By height; over ground_window_m and thing_window_m.
  std::vector<cv::Mat1f> ground_variance, ground_power, thing_variance;
  int ground_side = 1;
};

FilteredTile Filter(const SweptTile& tile, double sample_m, const HeightsOptions& options) {
  FilteredTile filtered;
  filtered.ground_side = BoxSide(options.ground_window_m / sample_m);
  const int thing_side = BoxSide(options.thing_window_m / sample_m);
  const size_t count = tile.heights.size();
  filtered.ground_variance.resize(count);
  filtered.ground_power.resize(count);
  filtered.thing_variance.resize(count);
  cv::parallel_for_({0, static_cast<int>(count)}, [&](const cv::Range& range) {
    for (int i = range.start; i < range.end; ++i) {
      const auto h = static_cast<size_t>(i);
      filtered.ground_variance[h] = Box(tile.variance[h], filtered.ground_side);
      filtered.ground_power[h] = Box(tile.power[h], filtered.ground_side);
      filtered.thing_variance[h] = Box(tile.variance[h], thing_side);
    }
  });
  return filtered;
}

struct Peak {
  size_t index = 0;
  double height = 0.0;  // above the proposal
  float correlation = 0.0f;
  double curvature = 0.0;  // of the correlation, 1/m^2, negative
};

Peak HighestPeak(const std::vector<double>& heights, const std::vector<float>& correlation) {
  Peak peak;
  const auto best = std::max_element(correlation.begin(), correlation.end());
  peak.index = static_cast<size_t>(best - correlation.begin());
  peak.height = heights[peak.index];
  peak.correlation = *best;
  if (peak.index == 0 || peak.index + 1 == heights.size()) return peak;
  const double step = heights[1] - heights[0];
  const double before = correlation[peak.index - 1], after = correlation[peak.index + 1];
  const double bend = before + after - 2.0 * peak.correlation;
  if (bend >= 0.0) return peak;
  peak.height += 0.5 * step * (before - after) / bend;
  peak.curvature = bend / (step * step);
  return peak;
}

// The sample of the cell that differs most at the ground's height, and the one that gains most.
struct ThingMeasure {
  float worst_variance = 0.0f;
  float gain = 0.0f;
  double gain_height = 0.0;
};

ThingMeasure MeasureThing(const FilteredTile& filtered,
                          const std::vector<double>& heights,
                          const cv::Rect& samples,
                          double ground,
                          double min_thing_height_m) {
  ThingMeasure measure;
  for (int row = samples.y; row < samples.y + samples.height; ++row) {
    for (int col = samples.x; col < samples.x + samples.width; ++col) {
      float on_ground = std::numeric_limits<float>::infinity(), above = on_ground;
      double above_height = ground;
      for (size_t h = 0; h < heights.size(); ++h) {
        const float variance = filtered.thing_variance[h](row, col);
        if (std::abs(heights[h] - ground) <= kGroundReliefM) {
          on_ground = std::min(on_ground, variance);
        } else if (heights[h] >= ground + min_thing_height_m && variance < above) {
          above = variance;
          above_height = heights[h];
        }
      }
      measure.worst_variance = std::max(measure.worst_variance, on_ground);
      const float gain = std::log((on_ground + kLeastVariance) / (above + kLeastVariance));
      if (!std::isfinite(gain) || gain <= measure.gain) continue;
      measure.gain = gain;
      measure.gain_height = above_height;
    }
  }
  return measure;
}

}  // namespace

HeightEvidence EmptyEvidence(const Grid& grid) {
  HeightEvidence evidence;
  for (cv::Mat1f* raster : {&evidence.ground,
                            &evidence.correlation,
                            &evidence.peak_width,
                            &evidence.num_views,
                            &evidence.baseline_ratio,
                            &evidence.contrast,
                            &evidence.noise,
                            &evidence.disagreement,
                            &evidence.gain,
                            &evidence.gain_height}) {
    *raster = cv::Mat1f(grid.num_rows, grid.num_cols, kNaN);
  }
  evidence.num_views.setTo(0.0f);
  evidence.baseline_ratio.setTo(0.0f);
  return evidence;
}

void MeasureCells(const SweptTile& tile,
                  const cv::Rect& core,
                  const SampleGrid& samples,
                  const ProposalSurface& surface,
                  const HeightsOptions& options,
                  HeightEvidence& evidence) {
  const FilteredTile filtered = Filter(tile, samples.SampleM(), options);
  const int n = samples.samples_per_cell;
  std::vector<float> correlation(tile.heights.size());
  for (int row = core.y; row < core.y + core.height; ++row) {
    for (int col = core.x; col < core.x + core.width; ++col) {
      const int down = row - tile.cells.y, right = col - tile.cells.x;
      const cv::Point block(right / samples.cells_per_block, down / samples.cells_per_block);
      const float num_views = tile.num_views(block);
      evidence.num_views(row, col) = num_views;
      evidence.baseline_ratio(row, col) = tile.baseline_ratio(block);
      if (num_views < 2.0f) continue;
      const cv::Point middle(right * n + n / 2, down * n + n / 2);
      for (size_t h = 0; h < correlation.size(); ++h) {
        const float power = filtered.ground_power[h](middle) + kLeastVariance;
        correlation[h] = 1.0f - (filtered.ground_variance[h](middle) + kLeastVariance) / power;
      }
      const Peak peak = HighestPeak(tile.heights, correlation);
      evidence.ground(row, col) = static_cast<float>(surface.At(row, col) + peak.height);
      evidence.correlation(row, col) = peak.correlation;
      const float variance = filtered.ground_variance[peak.index](middle);
      evidence.contrast(row, col) = std::sqrt(filtered.ground_power[peak.index](middle));
      evidence.noise(row, col) = std::sqrt(variance);
      const double num_independent =
          kIndependentShare * filtered.ground_side * filtered.ground_side * (num_views - 1.0);
      evidence.peak_width(row, col) = static_cast<float>(
          std::sqrt(2.0 * (1.0 - peak.correlation) / (num_independent * -peak.curvature)));
      const ThingMeasure thing = MeasureThing(filtered,
                                              tile.heights,
                                              {right * n, down * n, n, n},
                                              peak.height,
                                              options.min_thing_height_m);
      evidence.disagreement(row, col) = std::log(thing.worst_variance + kLeastVariance);
      evidence.gain(row, col) = thing.gain;
      evidence.gain_height(row, col) =
          static_cast<float>(surface.At(row, col) + std::max(thing.gain_height, peak.height));
    }
  }
}

}  // namespace freelsd
