#include "engine/cover/guided_filter.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Dense>
#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

constexpr int kNumColours = 3;
// Rows that are processed at once, so that working memory does not grow with the map.
constexpr int kNumFilterRows = 256;
// A cell counts if the photograph shows at least this share of it.
constexpr float kLeastSeenShare = 0.5f;
// No square is empty where a cell counts.
constexpr float kEmptySquare = 1e-3f;

using Colours = std::array<cv::Mat1f, kNumColours>;

struct Guided {
  cv::Mat1f values;
  // 1 where both are known, else 0.
  cv::Mat1f weight;
  // 0 to 1.
  Colours colours;
};

// Colour of the map's cells.
void AddColours(const Orthophoto& photo, Guided& guided) {
  const cv::Size size = guided.values.size();
  cv::Mat3b image;
  cv::Mat1b seen;
  cv::resize(photo.image, image, size, 0.0, 0.0, cv::INTER_AREA);
  cv::resize(photo.seen, seen, size, 0.0, 0.0, cv::INTER_AREA);
  for (cv::Mat1f& colour : guided.colours) colour = cv::Mat1f::zeros(size);
  guided.weight = cv::Mat1f::zeros(size);
  for (int row = 0; row < size.height; ++row) {
    for (int col = 0; col < size.width; ++col) {
      if (seen(row, col) < 255.0f * kLeastSeenShare || std::isnan(guided.values(row, col)))
        continue;
      guided.weight(row, col) = 1.0f;
      for (int colour = 0; colour < kNumColours; ++colour) {
        guided.colours[static_cast<size_t>(colour)](row, col) =
            static_cast<float>(image(row, col)[colour]) / static_cast<float>(seen(row, col));
      }
    }
  }
}

// Weighted means over the square around each cell.
class Means {
 public:
  Means(const cv::Mat1f& weight, int radius) : weight_(weight), side_(2 * radius + 1) {
    sum_ = cv::max(SumOf(weight), kEmptySquare);
  }
  cv::Mat1f Of(const cv::Mat1f& values) const { return SumOf(values.mul(weight_)) / sum_; }

 private:
  cv::Mat1f SumOf(const cv::Mat1f& values) const {
    cv::Mat1f sum;
    cv::boxFilter(values, sum, CV_32F, {side_, side_}, {-1, -1}, false, cv::BORDER_CONSTANT);
    return sum;
  }

  cv::Mat1f weight_;
  int side_;
  cv::Mat1f sum_;
};

// Weights of the colours in each square.
Colours Slopes(const Guided& guided,
               const Means& means,
               const Colours& mean_colours,
               const cv::Mat1f& mean_value,
               double least_contrast) {
  Colours covariance, slopes;
  std::array<Colours, kNumColours> spread;
  for (size_t i = 0; i < kNumColours; ++i) {
    covariance[i] =
        means.Of(guided.colours[i].mul(guided.values)) - mean_colours[i].mul(mean_value);
    for (size_t j = 0; j <= i; ++j) {
      spread[i][j] =
          means.Of(guided.colours[i].mul(guided.colours[j])) - mean_colours[i].mul(mean_colours[j]);
    }
    slopes[i].create(mean_value.size());
  }
  const Eigen::Matrix3d pull = least_contrast * least_contrast * Eigen::Matrix3d::Identity();
  for (int row = 0; row < mean_value.rows; ++row) {
    for (int col = 0; col < mean_value.cols; ++col) {
      Eigen::Matrix3d matrix;
      Eigen::Vector3d vector;
      for (size_t i = 0; i < kNumColours; ++i) {
        vector(static_cast<int>(i)) = covariance[i](row, col);
        for (size_t j = 0; j < kNumColours; ++j) {
          matrix(static_cast<int>(i), static_cast<int>(j)) =
              spread[std::max(i, j)][std::min(i, j)](row, col);
        }
      }
      const Eigen::Vector3d slope = (matrix + pull).inverse() * vector;
      for (size_t i = 0; i < kNumColours; ++i) {
        slopes[i](row, col) = static_cast<float>(slope(static_cast<int>(i)));
      }
    }
  }
  return slopes;
}

cv::Mat1f Filtered(const Guided& guided, int radius, double least_contrast) {
  const Means means(guided.weight, radius);
  const cv::Mat1f mean_value = means.Of(guided.values);
  Colours mean_colours;
  for (size_t i = 0; i < kNumColours; ++i) mean_colours[i] = means.Of(guided.colours[i]);
  const Colours slopes = Slopes(guided, means, mean_colours, mean_value, least_contrast);
  cv::Mat1f offset = mean_value.clone();
  for (size_t i = 0; i < kNumColours; ++i) offset -= slopes[i].mul(mean_colours[i]);
  cv::Mat1f filtered = means.Of(offset);
  for (size_t i = 0; i < kNumColours; ++i) {
    filtered += means.Of(slopes[i]).mul(guided.colours[i]);
  }
  return filtered;
}

}  // namespace

cv::Mat1f SmoothedByPhoto(const cv::Mat1f& values,
                          const Orthophoto& photo,
                          double cell_size_m,
                          double radius_m,
                          double least_contrast) {
  const int radius = static_cast<int>(std::lround(radius_m / cell_size_m));
  if (photo.image.empty() || radius == 0) return values;
  const int cells_per_cell = photo.image.rows / values.rows;
  cv::Mat1f smoothed = values.clone();
  for (int row = 0; row < values.rows; row += kNumFilterRows) {
    const int end = std::min(values.rows, row + kNumFilterRows);
    // What a cell depends on reaches two radii far.
    const cv::Range rows(std::max(0, row - 2 * radius), std::min(values.rows, end + 2 * radius));
    const cv::Range photo_rows(rows.start * cells_per_cell, rows.end * cells_per_cell);
    Orthophoto band;
    band.image = photo.image.rowRange(photo_rows);
    band.seen = photo.seen.rowRange(photo_rows);
    Guided guided;
    guided.values = values.rowRange(rows).clone();
    AddColours(band, guided);
    const cv::Mat1b counts = guided.weight > 0.0f;
    guided.values.setTo(0.0f, ~counts);
    const cv::Range own(row - rows.start, end - rows.start);
    Filtered(guided, radius, least_contrast)
        .rowRange(own)
        .copyTo(smoothed.rowRange(row, end), counts.rowRange(own));
  }
  return smoothed;
}

}  // namespace freelsd
