#include "engine/heights/cell_evidence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <opencv2/imgproc.hpp>

#include "engine/heights/thing_measure.h"

namespace freelsd {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
// Samples of a window tell each other: neighbours share pixels.
constexpr double kIndependentShare = 0.5;

cv::Mat1f Box(const cv::Mat1f& values, int side) {
  cv::Mat1f mean;
  cv::boxFilter(values, mean, -1, {side, side}, {-1, -1}, true, cv::BORDER_REPLICATE);
  return mean;
}

// Weights of a cell and its neighbours along one axis: a narrow window, and a wide one for ground
// with little contrast.
constexpr std::array<float, 3> kNarrow{0.25f, 0.5f, 0.25f};
constexpr std::array<float, 5> kWide{0.0625f, 0.25f, 0.375f, 0.25f, 0.0625f};

template <size_t num_weights>
cv::Mat1f Weighted(const cv::Mat1f& cells, const std::array<float, num_weights>& weights) {
  cv::Mat1f kernel(1, static_cast<int>(num_weights));
  std::copy(weights.begin(), weights.end(), kernel.begin());
  cv::Mat1f sum;
  cv::sepFilter2D(cells, sum, -1, kernel, kernel, {-1, -1}, 0.0, cv::BORDER_REPLICATE);
  return sum;
}

// Number of equally weighted cells that would average as well.
template <size_t num_weights>
double NumCells(const std::array<float, num_weights>& weights) {
  double sum_of_squares = 0.0;
  for (const float weight : weights) sum_of_squares += weight * weight;
  return 1.0 / (sum_of_squares * sum_of_squares);
}

// By height, one value per cell.
struct GroundVolume {
  std::vector<cv::Mat1f> variance, power;
  // Samples that tell something of their own.
  double num_samples = 1.0;
};

struct FilteredTile {
  GroundVolume narrow, wide;
  // By height and sample; over thing_window_m.
  std::vector<cv::Mat1f> thing_variance;
};

FilteredTile Filter(const SweptTile& tile, const SampleGrid& samples, double thing_window_m) {
  FilteredTile filtered;
  const size_t count = tile.heights.size();
  const double per_cell = kIndependentShare * samples.samples_per_cell * samples.samples_per_cell;
  filtered.narrow = {std::vector<cv::Mat1f>(count), std::vector<cv::Mat1f>(count)};
  filtered.narrow.num_samples = per_cell * NumCells(kNarrow);
  filtered.wide = {std::vector<cv::Mat1f>(count), std::vector<cv::Mat1f>(count)};
  filtered.wide.num_samples = per_cell * NumCells(kWide);
  filtered.thing_variance.resize(count);
  const int thing_side = BoxSide(thing_window_m / samples.SampleM());
  cv::parallel_for_({0, static_cast<int>(count)}, [&](const cv::Range& range) {
    for (int i = range.start; i < range.end; ++i) {
      const auto h = static_cast<size_t>(i);
      cv::Mat1f variance, power;
      cv::resize(tile.variance[h], variance, tile.cells.size(), 0.0, 0.0, cv::INTER_AREA);
      cv::resize(tile.power[h], power, tile.cells.size(), 0.0, 0.0, cv::INTER_AREA);
      filtered.narrow.variance[h] = Weighted(variance, kNarrow);
      filtered.narrow.power[h] = Weighted(power, kNarrow);
      filtered.wide.variance[h] = Weighted(variance, kWide);
      filtered.wide.power[h] = Weighted(power, kWide);
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

struct MeasuredGround {
  Peak peak;
  float width = kNaN, contrast = kNaN, noise = kNaN;
};

// `cell`: of the tile.
MeasuredGround MeasureIn(const GroundVolume& volume,
                         const std::vector<double>& heights,
                         const cv::Point& cell,
                         float num_views) {
  std::vector<float> correlation(heights.size());
  for (size_t h = 0; h < correlation.size(); ++h) {
    correlation[h] = 1.0f - (volume.variance[h](cell) + kLeastVariance) /
                                (volume.power[h](cell) + kLeastVariance);
  }
  MeasuredGround ground;
  ground.peak = HighestPeak(heights, correlation);
  ground.contrast = std::sqrt(volume.power[ground.peak.index](cell));
  ground.noise = std::sqrt(volume.variance[ground.peak.index](cell));
  const double num_independent = volume.num_samples * (num_views - 1.0);
  ground.width = static_cast<float>(std::sqrt(2.0 * (1.0 - ground.peak.correlation) /
                                              (num_independent * -ground.peak.curvature)));
  return ground;
}

// By the narrow window, unless its peak is too wide.
MeasuredGround MeasureGround(const FilteredTile& filtered,
                             const std::vector<double>& heights,
                             const cv::Point& cell,
                             float num_views,
                             double max_narrow_width_m) {
  const MeasuredGround narrow = MeasureIn(filtered.narrow, heights, cell, num_views);
  if (narrow.width <= max_narrow_width_m) return narrow;
  return MeasureIn(filtered.wide, heights, cell, num_views);
}

// The same for all samples of a cell.
void SetSamples(cv::Mat1f& raster, const cv::Rect& samples, float value) {
  raster(samples).setTo(value);
}

}  // namespace

HeightEvidence EmptyEvidence(const Grid& grid) {
  HeightEvidence evidence;
  for (cv::Mat1f* raster : {&evidence.proposal,
                            &evidence.ground,
                            &evidence.correlation,
                            &evidence.peak_width,
                            &evidence.num_views,
                            &evidence.baseline_ratio,
                            &evidence.contrast,
                            &evidence.noise,
                            &evidence.disagreement,
                            &evidence.gain,
                            &evidence.gain_height,
                            &evidence.proposed_gain}) {
    *raster = cv::Mat1f(grid.num_rows, grid.num_cols, kNaN);
  }
  evidence.num_views.setTo(0.0f);
  evidence.baseline_ratio.setTo(0.0f);
  return evidence;
}

void MeasureCells(const SweptTile& tile,
                  const cv::Rect& core,
                  const SweepGround& ground,
                  const HeightsOptions& options,
                  HeightEvidence& evidence) {
  const SampleGrid& samples = ground.samples;
  const FilteredTile filtered = Filter(tile, samples, options.thing_window_m);
  const int n = samples.samples_per_cell;
  const cv::Size size = tile.variance.front().size();
  SampleHeights at{cv::Mat1f(size, kNaN), cv::Mat1f(size, kNaN)};
  for (int row = core.y; row < core.y + core.height; ++row) {
    for (int col = core.x; col < core.x + core.width; ++col) {
      const int down = row - tile.cells.y, right = col - tile.cells.x;
      const cv::Point block(right / samples.cells_per_block, down / samples.cells_per_block);
      evidence.num_views(row, col) = tile.num_views(block);
      evidence.baseline_ratio(row, col) = tile.baseline_ratio(block);
      if (tile.num_views(block) < 2.0f) continue;
      const auto surface = static_cast<float>(ground.surface.At(row, col));
      evidence.proposal(row, col) = surface;
      const MeasuredGround measured = MeasureGround(
          filtered, tile.heights, {right, down}, tile.num_views(block), options.max_narrow_width_m);
      evidence.ground(row, col) = surface + static_cast<float>(measured.peak.height);
      evidence.correlation(row, col) = measured.peak.correlation;
      evidence.peak_width(row, col) = measured.width;
      evidence.contrast(row, col) = measured.contrast;
      evidence.noise(row, col) = measured.noise;
      const cv::Rect cell(right * n, down * n, n, n);
      SetSamples(at.ground, cell, static_cast<float>(measured.peak.height));
      SetSamples(at.proposed, cell, ground.proposal.upper(row, col) - surface);
    }
  }
  const ThingVariances variances =
      CompareHeights(filtered.thing_variance, tile.heights, at, options.min_thing_height_m);
  for (int row = core.y; row < core.y + core.height; ++row) {
    for (int col = core.x; col < core.x + core.width; ++col) {
      if (evidence.num_views(row, col) < 2.0f) continue;
      const cv::Rect cell((col - tile.cells.x) * n, (row - tile.cells.y) * n, n, n);
      const ThingMeasure thing = MeasureThing(variances, cell);
      evidence.disagreement(row, col) = std::log(thing.worst_variance + kLeastVariance);
      evidence.gain(row, col) = thing.gain;
      evidence.proposed_gain(row, col) = thing.proposed_gain;
      evidence.gain_height(row, col) =
          static_cast<float>(ground.surface.At(row, col)) + thing.gain_height;
    }
  }
}

}  // namespace freelsd
