#include "engine/glide/height_pyramid.h"

#include <algorithm>

#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

// Each level's blocks are four times as wide as those of the level below.
constexpr int kShift = 2;
// Past the edge of a block, so that the next block is found. Metres.
constexpr double kPastEdge = 1e-3;

cv::Mat1f BlockMaxima(const cv::Mat1f& finer) {
  constexpr int kSize = 1 << kShift;
  cv::Mat1f maxima((finer.rows + kSize - 1) / kSize, (finer.cols + kSize - 1) / kSize);
  cv::Mat row(1, finer.cols, CV_32F);
  for (int i = 0; i < maxima.rows; ++i) {
    const int end = std::min(finer.rows, (i + 1) * kSize);
    finer.row(i * kSize).copyTo(row);
    for (int k = i * kSize + 1; k < end; ++k) cv::max(row, cv::Mat(finer.row(k)), row);
    const float* const values = row.ptr<float>(0);
    for (int j = 0; j < maxima.cols; ++j) {
      maxima(i, j) =
          *std::max_element(values + j * kSize, values + std::min(finer.cols, (j + 1) * kSize));
    }
  }
  return maxima;
}

// Length at which the line leaves the block, along one axis.
double ExitAlong(double place, double step, int block, int size) {
  if (step > 0.0) return ((block + 1) * size - place) / step;
  if (step < 0.0) return (block * size - place) / step;
  return 1e12;
}

}  // namespace

HeightPyramid::HeightPyramid(const cv::Mat1f& top, int margin_cells) {
  const int side = 2 * margin_cells + 1;
  cv::dilate(top, levels_[0], cv::Mat1b(side, side, uchar{1}));
  for (size_t level = 1; level < levels_.size(); ++level) {
    levels_[level] = BlockMaxima(levels_[level - 1]);
  }
}

bool HeightPyramid::IsClear(const Eigen::Vector2d& place, double height, double clearance) const {
  const cv::Mat1f& top = levels_[0];
  const bool is_inside =
      place.x() >= 0.0 && place.y() >= 0.0 && place.x() < top.cols && place.y() < top.rows;
  if (!is_inside) return false;
  return height -
             static_cast<double>(top(static_cast<int>(place.y()), static_cast<int>(place.x()))) >=
         clearance;
}

ClearWay HeightPyramid::ClearWayAlong(const SlopingLine& line,
                                      double clearance,
                                      double wanted) const {
  ClearWay way;
  int level = kNumLevels - 1;
  while (way.length < line.length) {
    ++way.num_steps;
    const Eigen::Vector2d place = line.begin + way.length * line.step_per_metre;
    const bool is_inside = place.x() >= 0.0 && place.y() >= 0.0 && place.x() < levels_[0].cols &&
                           place.y() < levels_[0].rows;
    if (!is_inside) return way;
    const int shift = level * kShift;
    const int col = static_cast<int>(place.x()) >> shift;
    const int row = static_cast<int>(place.y()) >> shift;
    const double past = way.length + kPastEdge +
                        std::min(ExitAlong(place.x(), line.step_per_metre.x(), col, 1 << shift),
                                 ExitAlong(place.y(), line.step_per_metre.y(), row, 1 << shift));
    const double exit = std::min(line.length, past);
    const double above = line.height - line.loss_per_metre * exit -
                         static_cast<double>(levels_[static_cast<size_t>(level)](row, col));
    if (above < wanted && level > 0) {
      --level;
      continue;
    }
    if (above < clearance) return way;
    if (above < wanted) {
      if (!way.low.empty() && way.low.back().second == way.length) {
        way.low.back().second = exit;
      } else {
        way.low.emplace_back(way.length, exit);
      }
    } else if (level < kNumLevels - 1) {
      ++level;
    }
    way.length = exit;
  }
  return way;
}

}  // namespace freelsd
