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

std::vector<cv::Vec4d> LogGains(size_t num_layers,
                                const std::vector<Comparison>& comparisons,
                                double gain_sd) {
  using Index = Eigen::Index;
  std::vector<cv::Vec4d> gains(num_layers, cv::Vec4d::all(0.0));
  if (num_layers == 0) return gains;
  const double prior = kComparisonSd * kComparisonSd / (gain_sd * gain_sd);
  std::vector<Eigen::Triplet<double>> entries;
  const auto count = static_cast<Index>(num_layers);
  for (Index i = 0; i < count; ++i) entries.emplace_back(i, i, prior);
  Eigen::MatrixX4d right = Eigen::MatrixX4d::Zero(count, 4);
  for (const Comparison& comparison : comparisons) {
    const auto a = static_cast<Index>(comparison.first), b = static_cast<Index>(comparison.second);
    const double weight = comparison.num_cells / (comparison.num_cells + 100.0);
    entries.emplace_back(a, a, weight);
    entries.emplace_back(b, b, weight);
    entries.emplace_back(a, b, -weight);
    entries.emplace_back(b, a, -weight);
    for (int c = 0; c < 4; ++c) {
      right(a, c) += weight * comparison.log_ratio[c];
      right(b, c) -= weight * comparison.log_ratio[c];
    }
  }
  Eigen::SparseMatrix<double> normal(count, count);
  normal.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(normal);
  Eigen::MatrixX4d solution = solver.solve(right);
  solution.rowwise() -= solution.colwise().mean().eval();
  for (Index i = 0; i < count; ++i) {
    for (int c = 0; c < 4; ++c) gains[static_cast<size_t>(i)][c] = solution(i, c);
  }
  return gains;
}

}  // namespace freelsd
