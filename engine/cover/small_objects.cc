#include "engine/cover/small_objects.h"

#include <algorithm>
#include <array>

#include <opencv2/imgproc.hpp>

#include "engine/cover/photo_bands.h"
#include "engine/cover/photo_features.h"
#include "engine/geometry/geometry.h"

namespace freelsd {
namespace {

// Deviation of the blur before colours are compared, which removes blades of grass.
constexpr double kBlurM = 0.3;
// Number of times the surroundings are measured, each time without the outliers found before.
constexpr int kNumPasses = 3;
// Least variance of surroundings: two shares of colour, log brightness.
const Eigen::Vector3f kLeastVariance(1e-4f, 1e-4f, 4e-4f);
// Rows of a strip, without the surroundings of its own cells.
constexpr int kNumStripRows = 256;
// Avoids a division by zero: the mean is 0 where nothing counts.
constexpr double kMinWindowWeight = 1e-6;

// Moments of the colours in a square around every cell, over the cells that count.
struct Surroundings {
  cv::Mat1f weight;
  ColorPlanes mean;
  // 00, 01, 02, 11, 12, 22.
  std::array<cv::Mat1f, 6> moments;
};

Surroundings SurroundingsOf(const ColorPlanes& colors, const cv::Mat1f& counts, int side) {
  const auto mean_of = [&](const cv::Mat1f& values) {
    return BoxMean(values, side, BoxBorder::kNothing);
  };
  Surroundings around;
  around.weight = mean_of(counts) + kMinWindowWeight;
  size_t pair = 0;
  for (size_t i = 0; i < 3; ++i) {
    const cv::Mat1f counted = colors[i].mul(counts);
    around.mean[i] = mean_of(counted);
    for (size_t j = i; j < 3; ++j) around.moments[pair++] = mean_of(counted.mul(colors[j]));
  }
  return around;
}

// Squared deviation (Mahalanobis) of a cell's colour from its surroundings.
float SquaredDeviation(const ColorPlanes& colors, const Surroundings& around, int row, int col) {
  const float share = 1.0f / around.weight(row, col);
  Eigen::Vector3f mean, offset;
  for (size_t i = 0; i < 3; ++i) {
    mean[Eigen::Index(i)] = share * around.mean[i](row, col);
    offset[Eigen::Index(i)] = colors[i](row, col) - mean[Eigen::Index(i)];
  }
  Eigen::Matrix3f covariance;
  size_t pair = 0;
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) {
      const float moment = share * around.moments[pair++](row, col);
      covariance(i, j) = covariance(j, i) = moment - mean[i] * mean[j];
    }
  }
  // Rounding may make a variance negative.
  covariance.diagonal() = covariance.diagonal().cwiseMax(0.0f) + kLeastVariance;
  return offset.dot(covariance.inverse() * offset);
}

// Of all cells. Strip by strip, because the moments of a strip need ten rasters.
cv::Mat1f SquaredDeviations(const ColorPlanes& colors, const cv::Mat1f& counts, int side) {
  cv::Mat1f squares(counts.size());
  for (int first = 0; first < squares.rows; first += kNumStripRows) {
    const int end = std::min(squares.rows, first + kNumStripRows);
    const cv::Range rows(std::max(0, first - side), std::min(squares.rows, end + side));
    const ColorPlanes strip{
        colors[0].rowRange(rows), colors[1].rowRange(rows), colors[2].rowRange(rows)};
    const Surroundings around = SurroundingsOf(strip, counts.rowRange(rows), side);
    for (int row = first; row < end; ++row) {
      for (int col = 0; col < squares.cols; ++col) {
        squares(row, col) = SquaredDeviation(strip, around, row - rows.start, col);
      }
    }
  }
  return squares;
}

}  // namespace

cv::Mat1b SmallObjects(const Orthophoto& photo, const CoverOptions& options) {
  const double cell = photo.grid.cell_size_m;
  cv::Mat1f seen;
  photo.seen.convertTo(seen, CV_32F, 1.0 / 255.0);
  const ColorPlanes colors = BlurredColors(photo.image, seen, kBlurM / cell);
  const int side = BoxSide(options.object_surroundings_m / cell);
  const cv::Mat neighbours = cv::getStructuringElement(cv::MORPH_ELLIPSE, {3, 3});
  const double trim = options.max_surroundings_deviations;
  cv::Mat1f counts = seen.clone();
  cv::Mat1f squares;
  for (int pass = 0; pass < kNumPasses; ++pass) {
    squares = SquaredDeviations(colors, counts, side);
    cv::Mat1b is_other;
    cv::dilate(squares > trim * trim, is_other, neighbours);
    counts = seen.clone();
    counts.setTo(0.0f, is_other);
  }
  const double least = options.min_object_deviations * options.min_object_deviations;
  const cv::Mat1b stands_out = (squares > least) & photo.seen;
  return WithoutSpecks(stands_out, options.min_object_area_m2 / (cell * cell));
}

cv::Mat1b FindSmallObjects(const Orthophoto& photo, const Grid& grid, const CoverOptions& options) {
  if (photo.image.empty() || options.min_object_deviations <= 0.0) return {};
  // Each pass depends on cells farther out.
  const double halo_m = kNumPasses * options.object_surroundings_m;
  const auto find = [&](const PhotoBand& band) { return SmallObjects(band.photo, options); };
  return OnMap(FindInBands(photo, halo_m, find), grid);
}

}  // namespace freelsd
