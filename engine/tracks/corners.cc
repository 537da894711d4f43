#include "engine/tracks/corners.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <tuple>

#include <opencv2/imgproc.hpp>

#include "engine/geometry/geometry.h"

namespace freelsd {
namespace {

// Products of the gradients of one row, with one more entry at either end. Integers, so that sums
// are exact.
struct ProductRow {
  std::vector<int32_t> xx, xy, yy;

  explicit ProductRow(int num_cols) : xx(static_cast<size_t>(num_cols) + 2, 0), xy(xx), yy(xx) {}
};

// Sobel gradients from three rows that have one more pixel at either end.
FREELSD_SEVERAL_TARGETS void Multiply(const std::array<const uint8_t*, 3>& rows,
                                      int num_cols,
                                      int32_t* __restrict__ xx,
                                      int32_t* __restrict__ xy,
                                      int32_t* __restrict__ yy) {
  const auto [above, row, below] = rows;
  for (int i = 0; i < num_cols; ++i) {
    const int dx = above[i + 2] - above[i] + 2 * (row[i + 2] - row[i]) + below[i + 2] - below[i];
    const int dy =
        below[i] - above[i] + 2 * (below[i + 1] - above[i + 1]) + below[i + 2] - above[i + 2];
    xx[i] = dx * dx;
    xy[i] = dx * dy;
    yy[i] = dy * dy;
  }
}

FREELSD_SEVERAL_TARGETS void SumOfThree(const std::array<const int32_t*, 3>& rows,
                                        int count,
                                        int32_t* __restrict__ sums) {
  const auto [above, row, below] = rows;
  for (int i = 0; i < count; ++i) sums[i] = above[i] + row[i] + below[i];
}

// Twice the smaller eigenvalue of the gradients' products over 3x3 pixels, from sums over three
// rows that have one more entry at either end.
FREELSD_SEVERAL_TARGETS void SmallerEigenvalues(const int32_t* __restrict__ xx,
                                                const int32_t* __restrict__ xy,
                                                const int32_t* __restrict__ yy,
                                                int num_cols,
                                                float* __restrict__ strength) {
  for (int i = 0; i < num_cols; ++i) {
    const auto a = static_cast<float>(xx[i] + xx[i + 1] + xx[i + 2]);
    const auto b = static_cast<float>(2 * (xy[i] + xy[i + 1] + xy[i + 2]));
    const auto c = static_cast<float>(yy[i] + yy[i + 1] + yy[i + 2]);
    strength[i] = (a + c) - std::sqrt((a - c) * (a - c) + b * b);
  }
}

// 1 where the mask is not 0, the strength exceeds the threshold and no neighbour is stronger. Does
// not write the first and last column.
FREELSD_SEVERAL_TARGETS void MarkPeaks(const std::array<const float*, 3>& rows,
                                       const uint8_t* __restrict__ mask,
                                       float threshold,
                                       int num_cols,
                                       uint8_t* __restrict__ marks) {
  const auto [above, row, below] = rows;
  for (int x = 1; x < num_cols - 1; ++x) {
    float largest = 0.0F;
    for (const float value : {above[x - 1],
                              above[x],
                              above[x + 1],
                              row[x - 1],
                              row[x + 1],
                              below[x - 1],
                              below[x],
                              below[x + 1]}) {
      largest = largest < value ? value : largest;
    }
    const int is_peak = static_cast<int>(row[x] >= largest) & static_cast<int>(row[x] > threshold);
    marks[x] = static_cast<uint8_t>(is_peak & static_cast<int>(mask[x] != 0));
  }
}

cv::Mat1f Strengths(const cv::Mat1b& grey) {
  cv::Mat1b padded;
  cv::copyMakeBorder(grey, padded, 1, 1, 1, 1, cv::BORDER_REFLECT_101);
  const int num_cols = grey.cols, num_rows = grey.rows;
  const auto mirrored = [](int at, int length) {
    return cv::borderInterpolate(at, length, cv::BORDER_REFLECT_101);
  };
  std::array<ProductRow, 3> products{
      ProductRow(num_cols), ProductRow(num_cols), ProductRow(num_cols)};
  const auto load = [&](int y) {
    ProductRow& row = products[static_cast<size_t>(y % 3)];
    Multiply({padded[y], padded[y + 1], padded[y + 2]},
             num_cols,
             row.xx.data() + 1,
             row.xy.data() + 1,
             row.yy.data() + 1);
    for (std::vector<int32_t>* entries : {&row.xx, &row.xy, &row.yy}) {
      entries->front() = (*entries)[static_cast<size_t>(mirrored(-1, num_cols) + 1)];
      entries->back() = (*entries)[static_cast<size_t>(mirrored(num_cols, num_cols) + 1)];
    }
  };
  ProductRow sums(num_cols);
  cv::Mat1f strengths(grey.size());
  load(0);
  for (int y = 0; y < num_rows; ++y) {
    if (y + 1 < num_rows) load(y + 1);
    const ProductRow& above = products[static_cast<size_t>(mirrored(y - 1, num_rows) % 3)];
    const ProductRow& row = products[static_cast<size_t>(y % 3)];
    const ProductRow& below = products[static_cast<size_t>(mirrored(y + 1, num_rows) % 3)];
    SumOfThree({above.xx.data(), row.xx.data(), below.xx.data()}, num_cols + 2, sums.xx.data());
    SumOfThree({above.xy.data(), row.xy.data(), below.xy.data()}, num_cols + 2, sums.xy.data());
    SumOfThree({above.yy.data(), row.yy.data(), below.yy.data()}, num_cols + 2, sums.yy.data());
    SmallerEigenvalues(sums.xx.data(), sums.xy.data(), sums.yy.data(), num_cols, strengths[y]);
  }
  return strengths;
}

struct Corner {
  float strength = 0.0F;
  cv::Point place;
};

// The strongest is the greatest; among equal ones the last.
bool operator<(const Corner& a, const Corner& b) {
  return std::tuple(a.strength, a.place.y, a.place.x) <
         std::tuple(b.strength, b.place.y, b.place.x);
}

std::vector<Corner> Peaks(const cv::Mat1f& strengths, const cv::Mat1b& mask, double min_quality) {
  double strongest = 0.0;
  cv::minMaxLoc(strengths, nullptr, &strongest, nullptr, nullptr, mask);
  const auto threshold = static_cast<float>(strongest * min_quality);
  std::vector<Corner> corners;
  std::vector<uint8_t> marks(static_cast<size_t>(strengths.cols), 0);
  for (int y = 1; y + 1 < strengths.rows; ++y) {
    MarkPeaks({strengths[y - 1], strengths[y], strengths[y + 1]},
              mask[y],
              threshold,
              strengths.cols,
              marks.data());
    const uint8_t *first = marks.data(), *end = first + marks.size(), *mark = first;
    while ((mark = static_cast<const uint8_t*>(std::memchr(mark, 1, end - mark))) != nullptr) {
      const auto x = static_cast<int>(mark++ - first);
      corners.push_back({strengths(y, x), {x, y}});
    }
  }
  return corners;
}

// Accepted corners, by square cells with the least distance as their side.
class Neighbourhood {
 public:
  Neighbourhood(cv::Size size, double min_distance_px)
      : cell_px_(std::max(cvCeil(min_distance_px), 1)),
        min_squared_px_(min_distance_px * min_distance_px),
        num_cols_(size.width / cell_px_ + 3),
        cells_(static_cast<size_t>(num_cols_) * static_cast<size_t>(size.height / cell_px_ + 3)) {}

  bool Take(const cv::Point& place) {
    for (int row = -1; row <= 1; ++row) {
      for (int col = -1; col <= 1; ++col) {
        for (const cv::Point& taken : cells_[CellOf(place, row, col)]) {
          const cv::Point difference = taken - place;
          if (difference.dot(difference) < min_squared_px_) return false;
        }
      }
    }
    cells_[CellOf(place, 0, 0)].push_back(place);
    return true;
  }

 private:
  size_t CellOf(const cv::Point& place, int row, int col) const {
    return static_cast<size_t>((place.y / cell_px_ + 1 + row) * num_cols_ + place.x / cell_px_ + 1 +
                               col);
  }

  int cell_px_;
  double min_squared_px_;
  int num_cols_;
  std::vector<std::vector<cv::Point>> cells_;
};

}  // namespace

std::vector<cv::Point> StrongestCorners(const cv::Mat1b& grey, const CornerWish& wish) {
  std::vector<cv::Point> chosen;
  Neighbourhood taken(grey.size(), wish.min_distance_px);
  // Few of many peaks are taken, so a full sort would be wasteful.
  std::vector<Corner> peaks = Peaks(Strengths(grey), wish.mask, wish.min_quality);
  std::make_heap(peaks.begin(), peaks.end());
  while (!peaks.empty() && static_cast<int>(chosen.size()) < wish.max_count) {
    std::pop_heap(peaks.begin(), peaks.end());
    if (taken.Take(peaks.back().place)) chosen.push_back(peaks.back().place);
    peaks.pop_back();
  }
  return chosen;
}

}  // namespace freelsd
