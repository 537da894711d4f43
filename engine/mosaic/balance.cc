#include "engine/mosaic/balance.h"

#include <algorithm>
#include <cmath>

#include <Eigen/SparseCholesky>

namespace freelsd {
namespace {

// Black and white values say nothing about gains.
constexpr int kMinValue = 6;
constexpr int kMaxValue = 247;
// Every second cell of both directions suffices.
constexpr int kCellStep = 2;
constexpr int kMinNumCells = 20;
// Deviation of a median from the truth: light and reflection change with the direction.
constexpr double kComparisonSd = 0.03;
constexpr double kHalfWeightCells = 100.0;
// Prior deviation of the trend: logarithm per distance. As good as unknown, or none.
constexpr double kTrendUnitM = 100.0;
constexpr double kTrendSd = 0.5;
constexpr double kNoTrend = 1e12;

bool IsMeasurable(const cv::Vec3b& color) {
  for (int c = 0; c < 3; ++c) {
    if (color[c] < kMinValue || color[c] > kMaxValue) return false;
  }
  return true;
}

double Median(std::vector<float>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

Comparison CompareLayers(const ViewLayer& first, const ViewLayer& second) {
  Comparison comparison;
  const cv::Rect common = first.cells & second.cells;
  std::vector<float> ratios[4];
  for (int row = common.y; row < common.br().y; row += kCellStep) {
    for (int col = common.x; col < common.br().x; col += kCellStep) {
      const cv::Point cell(col, row);
      if (!first.Shows(cell) || !second.Shows(cell)) continue;
      const cv::Point a = cell - first.cells.tl(), b = cell - second.cells.tl();
      const cv::Vec3b& color_a = first.picture(a);
      const cv::Vec3b& color_b = second.picture(b);
      if (!IsMeasurable(color_a) || !IsMeasurable(color_b)) continue;
      for (int c = 0; c < 3; ++c) {
        ratios[c].push_back(std::log(float(color_b[c]) / float(color_a[c])));
      }
      ratios[3].push_back(
          std::log((float(second.detail(b)) + 1.0f) / (float(first.detail(a)) + 1.0f)));
    }
  }
  comparison.num_cells = static_cast<int>(ratios[0].size());
  if (comparison.num_cells < kMinNumCells) return comparison;
  for (int c = 0; c < 4; ++c) comparison.log_ratio[c] = Median(ratios[c]);
  return comparison;
}

// Weight of a prior beside that of a comparison.
double PriorOf(double sd) { return kComparisonSd * kComparisonSd / (sd * sd); }

// Rows: the gains, then the trend per kTrendUnitM east and north. A comparison says that the second
// layer's gain is the first one's, less the ratio of their values and the trend between their
// cameras.
Eigen::MatrixX4d Solve(const std::vector<Eigen::Vector2d>& cameras_in_world,
                       const std::vector<Comparison>& comparisons,
                       double gain_prior,
                       double trend_prior) {
  const auto count = static_cast<Eigen::Index>(cameras_in_world.size());
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::MatrixX4d right = Eigen::MatrixX4d::Zero(count + 2, 4);
  for (Eigen::Index i = 0; i < count + 2; ++i) {
    entries.emplace_back(i, i, i < count ? gain_prior : trend_prior);
  }
  for (const Comparison& comparison : comparisons) {
    const Eigen::Vector2d baseline =
        (cameras_in_world[comparison.first] - cameras_in_world[comparison.second]) / kTrendUnitM;
    const Eigen::Index index[] = {static_cast<Eigen::Index>(comparison.first),
                                  static_cast<Eigen::Index>(comparison.second),
                                  count,
                                  count + 1};
    const double factor[] = {1.0, -1.0, -baseline.x(), -baseline.y()};
    const double weight = comparison.num_cells / (comparison.num_cells + kHalfWeightCells);
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) {
        entries.emplace_back(index[i], index[j], weight * factor[i] * factor[j]);
      }
      for (int c = 0; c < 4; ++c) {
        right(index[i], c) += weight * factor[i] * comparison.log_ratio[c];
      }
    }
  }
  Eigen::SparseMatrix<double> normal(count + 2, count + 2);
  normal.setFromTriplets(entries.begin(), entries.end());
  return Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(normal).solve(right);
}

}  // namespace

std::vector<Comparison> Compare(const std::vector<ViewLayer>& layers) {
  std::vector<Comparison> comparisons;
  for (size_t i = 0; i < layers.size(); ++i) {
    for (size_t j = i + 1; j < layers.size(); ++j) {
      Comparison comparison = CompareLayers(layers[i], layers[j]);
      if (comparison.num_cells < kMinNumCells) continue;
      comparison.first = i;
      comparison.second = j;
      comparisons.push_back(comparison);
    }
  }
  return comparisons;
}

cv::Vec3d Tone::Gain() const {
  return {std::exp(log_gain[0]), std::exp(log_gain[1]), std::exp(log_gain[2])};
}

cv::Vec3f Tone::FactorAt(const Eigen::Vector2d& place_in_world) const {
  const Eigen::Vector2d offset = place_in_world - camera_in_world;
  cv::Vec3f factor;
  for (int c = 0; c < 3; ++c) {
    const double trend = east[c] * offset.x() + north[c] * offset.y();
    factor[c] = static_cast<float>(std::exp(log_gain[c] + trend));
  }
  return factor;
}

std::vector<Tone> Balance(const std::vector<Eigen::Vector2d>& cameras_in_world,
                          const std::vector<Comparison>& comparisons,
                          double gain_sd) {
  std::vector<Tone> tones(cameras_in_world.size());
  if (tones.empty()) return tones;
  const auto count = static_cast<Eigen::Index>(tones.size());
  const double gain_prior = PriorOf(gain_sd);
  const Eigen::MatrixX4d colors =
      Solve(cameras_in_world, comparisons, gain_prior, PriorOf(kTrendSd));
  const Eigen::MatrixX4d details = Solve(cameras_in_world, comparisons, gain_prior, kNoTrend);
  for (Eigen::Index i = 0; i < count; ++i) {
    Tone& tone = tones[static_cast<size_t>(i)];
    for (int c = 0; c < 3; ++c) {
      tone.log_gain[c] = colors(i, c) - colors.col(c).head(count).mean();
      tone.east[c] = colors(count, c) / kTrendUnitM;
      tone.north[c] = colors(count + 1, c) / kTrendUnitM;
    }
    tone.log_gain[3] = details(i, 3) - details.col(3).head(count).mean();
    tone.camera_in_world = cameras_in_world[static_cast<size_t>(i)];
  }
  return tones;
}

}  // namespace freelsd
