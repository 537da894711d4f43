#include "engine/glide/node_mask.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace freelsd {

NodeMask::NodeMask(int num_rows, int num_cols)
    : nodes_(num_rows + 1, num_cols + 1, uchar{0}), crossings_(static_cast<size_t>(num_rows) + 1) {}

void NodeMask::AddCrossings(const Eigen::Vector2d& begin, const Eigen::Vector2d& end) {
  const Eigen::Vector2d& upper = begin.y() < end.y() ? begin : end;
  const Eigen::Vector2d& lower = begin.y() < end.y() ? end : begin;
  const double last = static_cast<double>(nodes_.rows) - 1.0;
  const int first_row = static_cast<int>(std::ceil(std::clamp(upper.y(), 0.0, last + 1.0)));
  const int end_row = static_cast<int>(std::ceil(std::clamp(lower.y(), 0.0, last + 1.0)));
  const int winding = begin.y() < end.y() ? 1 : -1;
  const double slope = (lower.x() - upper.x()) / (lower.y() - upper.y());
  for (int row = first_row; row < end_row; ++row) {
    crossings_[static_cast<size_t>(row)].push_back(
        {upper.x() + slope * (row - upper.y()), winding});
  }
}

void NodeMask::Fill(const std::vector<Eigen::Vector2d>& polygon) {
  double north = nodes_.rows, south = 0.0;
  for (size_t i = 0; i < polygon.size(); ++i) {
    AddCrossings(polygon[i], polygon[(i + 1) % polygon.size()]);
    north = std::min(north, polygon[i].y());
    south = std::max(south, polygon[i].y());
  }
  const int end_row = static_cast<int>(std::ceil(std::min(south, nodes_.rows + 0.0)));
  for (int row = static_cast<int>(std::max(0.0, north)); row < end_row; ++row) {
    FillRow(row, crossings_[static_cast<size_t>(row)]);
    crossings_[static_cast<size_t>(row)].clear();
  }
}

void NodeMask::FillRow(int row, std::vector<Crossing>& crossings) {
  std::sort(crossings.begin(), crossings.end(), [](const Crossing& a, const Crossing& b) {
    return a.col < b.col;
  });
  int winding = 0;
  for (size_t i = 0; i + 1 < crossings.size(); ++i) {
    winding += crossings[i].winding;
    if (winding == 0) continue;
    const int first = static_cast<int>(std::ceil(std::max(crossings[i].col, 0.0)));
    const int last =
        static_cast<int>(std::floor(std::min(crossings[i + 1].col, nodes_.cols - 1.0)));
    if (last >= first) {
      std::memset(nodes_.ptr(row) + first, 255, static_cast<size_t>(last - first) + 1);
    }
  }
}

cv::Mat1b NodeMask::WholeCells() const {
  const cv::Size size(nodes_.cols - 1, nodes_.rows - 1);
  cv::Mat1b cells = nodes_(cv::Rect({0, 0}, size)) & nodes_(cv::Rect({1, 0}, size));
  cells &= nodes_(cv::Rect({0, 1}, size));
  cells &= nodes_(cv::Rect({1, 1}, size));
  return cells;
}

}  // namespace freelsd
