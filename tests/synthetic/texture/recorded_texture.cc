#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include <opencv2/imgproc.hpp>

#include "tests/synthetic/noise.h"
#include "tests/synthetic/texture/texture.h"

namespace freelsd {
namespace {

constexpr int kLeastSidePx = 12;
// Weights are sharpened: over most of a triangle one piece alone is seen.
constexpr double kSharpness = 4.0;
enum Purpose : uint64_t { kPieceCol = 701, kPieceRow };

// As Uniform, without a generator of its own: it is asked thrice for every cell of a world.
double Between(uint64_t seed, uint64_t purpose, double low, double high) {
  constexpr int kNumBits = 53;
  const uint64_t bits = MixSeed(seed, purpose) >> (64 - kNumBits);
  return low + (high - low) * std::ldexp(static_cast<double>(bits), -kNumBits);
}

// The plane and the bowl that fit the brightness of a piece best, less its mean: what the lens and
// the light did.
cv::Mat3f SlowChange(const cv::Mat3f& piece) {
  constexpr int kNumTerms = 5;
  cv::Mat1d terms(static_cast<int>(piece.total()), kNumTerms + 1);
  for (int row = 0; row < piece.rows; ++row) {
    for (int col = 0; col < piece.cols; ++col) {
      const double x = 2.0 * col / (piece.cols - 1) - 1.0, y = 2.0 * row / (piece.rows - 1) - 1.0;
      const std::array<double, kNumTerms + 1> values{1.0, x, y, x * x, x * y, y * y};
      std::copy(values.begin(), values.end(), terms[row * piece.cols + col]);
    }
  }
  const cv::Mat values = piece.reshape(1, static_cast<int>(piece.total()));
  cv::Mat1d wanted;
  values.convertTo(wanted, CV_64F);
  cv::Mat1d weights;
  cv::solve(terms, wanted, weights, cv::DECOMP_NORMAL | cv::DECOMP_CHOLESKY);
  const cv::Mat fitted = terms * weights;
  cv::Mat change;
  fitted.convertTo(change, CV_32F);
  return change.reshape(3, piece.rows);
}

// A vertex of the lattice and how much of a place it has.
struct Corner {
  int col = 0;
  int row = 0;
  double weight = 0.0;
};

// The triangle around a place of the plane, in edges. The lattice is one of equal triangles.
std::array<Corner, 3> TriangleAround(double x, double y) {
  const double skewed_x = x - y / std::sqrt(3.0), skewed_y = 2.0 * y / std::sqrt(3.0);
  const int col = static_cast<int>(std::floor(skewed_x));
  const int row = static_cast<int>(std::floor(skewed_y));
  const double u = skewed_x - col, v = skewed_y - row;
  if (u + v < 1.0) {
    return {{{col, row, 1.0 - u - v}, {col + 1, row, u}, {col, row + 1, v}}};
  }
  return {{{col + 1, row + 1, u + v - 1.0}, {col, row + 1, 1.0 - u}, {col + 1, row, 1.0 - v}}};
}

}  // namespace

RecordedTexture::RecordedTexture(const cv::Mat3b& piece, uint64_t seed, double edge_ratio)
    : seed_(seed) {
  const int side = std::min(piece.cols, piece.rows);
  if (side < kLeastSidePx) {
    throw std::invalid_argument("texture: a piece is " + std::to_string(side) +
                                " pixels wide: must be at least " + std::to_string(kLeastSidePx));
  }
  piece.convertTo(piece_, CV_32F);
  piece_ -= SlowChange(piece_);
  const cv::Scalar mean = cv::mean(piece);
  for (int i = 0; i < 3; ++i) mean_[i] = static_cast<float>(mean[i]);
  edge_px_ = std::max(1, static_cast<int>(edge_ratio * side));
}

cv::Vec3f RecordedTexture::PieceAt(int vertex_col, int vertex_row, int col, int row) const {
  const uint64_t vertex = MixSeed(MixSeed(seed_, static_cast<uint64_t>(int64_t{vertex_col})),
                                  static_cast<uint64_t>(int64_t{vertex_row}));
  const double middle_col = Between(vertex, kPieceCol, edge_px_, piece_.cols - 1.0 - edge_px_);
  const double middle_row = Between(vertex, kPieceRow, edge_px_, piece_.rows - 1.0 - edge_px_);
  // The vertex in cells: its lattice is skewed.
  const double vertex_x = edge_px_ * (vertex_col + 0.5 * vertex_row);
  const double vertex_y = edge_px_ * 0.5 * std::sqrt(3.0) * vertex_row;
  const int from_col = static_cast<int>(std::lround(middle_col + col - vertex_x));
  const int from_row = static_cast<int>(std::lround(middle_row + row - vertex_y));
  return piece_(std::clamp(from_row, 0, piece_.rows - 1), std::clamp(from_col, 0, piece_.cols - 1));
}

cv::Vec3f RecordedTexture::At(int col, int row) const {
  std::array<Corner, 3> corners =
      TriangleAround(static_cast<double>(col) / edge_px_, static_cast<double>(row) / edge_px_);
  double sum = 0.0;
  for (Corner& corner : corners) {
    corner.weight = std::pow(corner.weight, kSharpness);
    sum += corner.weight;
  }
  double squares = 0.0;
  cv::Vec3f color(0.0f, 0.0f, 0.0f);
  for (const Corner& corner : corners) {
    const double weight = corner.weight / sum;
    if (weight < 1e-3) continue;
    squares += weight * weight;
    color += static_cast<float>(weight) * PieceAt(corner.col, corner.row, col, row);
  }
  return mean_ + color * static_cast<float>(1.0 / std::sqrt(squares));
}

}  // namespace freelsd
