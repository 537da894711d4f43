#include "engine/segmentation/edge_distance.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "engine/geometry/geometry.h"

namespace freelsd {
namespace {

// Row distances saturate here.
constexpr int kManyRows = 255;

cv::Mat1b FarByDistanceTransform(const cv::Mat1b& edges, double distance_px) {
  cv::Mat1f edge_distance_px;
  cv::distanceTransform(~edges, edge_distance_px, cv::DIST_L2, cv::DIST_MASK_5);
  return edge_distance_px > distance_px;
}

// By number of columns, from 0: largest number of rows at which an edge is still
// near. The distance depends only on the offset, so one edge gives the whole
// table.
std::vector<uint8_t> ReachOf(int radius_px, double distance_px) {
  cv::Mat1b edge(2 * radius_px + 1, 2 * radius_px + 1, uint8_t{0});
  edge(radius_px, radius_px) = 255;
  const cv::Mat1b is_far = FarByDistanceTransform(edge, distance_px);
  std::vector<uint8_t> reach;
  for (int col = 0; col <= radius_px && is_far(radius_px, radius_px + col) == 0; ++col) {
    int row = 0;
    while (row < radius_px && is_far(radius_px + row + 1, radius_px + col) == 0) ++row;
    reach.push_back(static_cast<uint8_t>(row));
  }
  return reach;
}

// Rows to the nearest edge in the same column, from the counts of the previous row.
FREELSD_SEVERAL_TARGETS void CountRows(const uint8_t* __restrict__ edges,
                                       const uint8_t* __restrict__ before,
                                       int num_cols,
                                       uint8_t* __restrict__ rows) {
  for (int x = 0; x < num_cols; ++x) {
    const int next = std::min<int>(before[x], kManyRows - 1) + 1;
    rows[x] = static_cast<uint8_t>(edges[x] != 0 ? 0 : next);
  }
}

FREELSD_SEVERAL_TARGETS void TakeNearer(const uint8_t* __restrict__ before,
                                        int num_cols,
                                        uint8_t* __restrict__ rows) {
  for (int x = 0; x < num_cols; ++x) {
    const int next = std::min<int>(before[x], kManyRows - 1) + 1;
    rows[x] = static_cast<uint8_t>(std::min<int>(rows[x], next));
  }
}

// The result has edge-free columns on either side.
cv::Mat1b RowsToEdge(const cv::Mat1b& edges, int radius_px) {
  cv::Mat1b rows(edges.rows, edges.cols + 2 * radius_px, static_cast<uint8_t>(kManyRows));
  const std::vector<uint8_t> none(static_cast<size_t>(edges.cols), kManyRows);
  for (int y = 0; y < edges.rows; ++y) {
    const uint8_t* before = y > 0 ? rows[y - 1] + radius_px : none.data();
    CountRows(edges[y], before, edges.cols, rows[y] + radius_px);
  }
  for (int y = edges.rows - 2; y >= 0; --y) {
    TakeNearer(rows[y + 1] + radius_px, edges.cols, rows[y] + radius_px);
  }
  return rows;
}

FREELSD_SEVERAL_TARGETS void ClearNear(const uint8_t* __restrict__ left,
                                       const uint8_t* __restrict__ right,
                                       uint8_t reach,
                                       int num_cols,
                                       uint8_t* __restrict__ is_far) {
  for (int x = 0; x < num_cols; ++x) {
    const uint8_t rows = std::min(left[x], right[x]);
    is_far[x] = static_cast<uint8_t>(rows > reach ? is_far[x] : 0);
  }
}

}  // namespace

cv::Mat1b FarFromEdges(const cv::Mat1b& edges, double distance_px) {
  // Every step of the distance transform is at least one pixel. It is compared as a float.
  const float radius_px = std::floor(std::max(static_cast<float>(distance_px), 0.0F));
  if (radius_px >= static_cast<float>(kManyRows)) return FarByDistanceTransform(edges, distance_px);
  const auto radius = static_cast<int>(radius_px);
  const std::vector<uint8_t> reach = ReachOf(radius, distance_px);
  const cv::Mat1b rows = RowsToEdge(edges, radius);
  cv::Mat1b is_far(edges.size(), uint8_t{255});
  for (int y = 0; y < edges.rows; ++y) {
    const uint8_t* row = rows[y] + radius;
    for (int col = 0; col < static_cast<int>(reach.size()); ++col) {
      ClearNear(row - col, row + col, reach[static_cast<size_t>(col)], edges.cols, is_far[y]);
    }
  }
  return is_far;
}

}  // namespace freelsd
