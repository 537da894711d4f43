#include "engine/geometry/remap_table.h"

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace freelsd {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

// Position of a pixel between its two nodes, 0..1.
float Share(int at_px, int node_spacing_px) {
  return static_cast<float>(at_px % node_spacing_px) / static_cast<float>(node_spacing_px);
}

// Interpolates one row of nodes at every pixel.
std::vector<cv::Vec2f> AlongRow(const cv::Vec2f* nodes, int num_pixels, int node_spacing_px) {
  std::vector<cv::Vec2f> sources(static_cast<size_t>(num_pixels));
  for (int u = 0; u < num_pixels; ++u) {
    const int col = u / node_spacing_px;
    const float along = Share(u, node_spacing_px);
    sources[static_cast<size_t>(u)] = nodes[col] * (1 - along) + nodes[col + 1] * along;
  }
  return sources;
}

}  // namespace

cv::Mat2f RemapTable(
    const cv::Size& size,
    int node_spacing_px,
    const std::function<std::optional<Eigen::Vector2d>(double, double)>& source_at) {
  cv::Mat2f nodes(size.height / node_spacing_px + 2, size.width / node_spacing_px + 2);
  for (int row = 0; row < nodes.rows; ++row) {
    for (int col = 0; col < nodes.cols; ++col) {
      const std::optional<Eigen::Vector2d> source =
          source_at(col * node_spacing_px, row * node_spacing_px);
      nodes(row, col) =
          source ? cv::Vec2f(static_cast<float>(source->x()), static_cast<float>(source->y()))
                 : cv::Vec2f(kNaN, kNaN);
    }
  }
  cv::Mat2f table(size);
  std::vector<cv::Vec2f> upper, lower = AlongRow(nodes[0], size.width, node_spacing_px);
  for (int v = 0; v < table.rows; ++v) {
    if (v % node_spacing_px == 0) {
      upper = std::move(lower);
      lower = AlongRow(nodes[v / node_spacing_px + 1], size.width, node_spacing_px);
    }
    const float down = Share(v, node_spacing_px);
    for (int u = 0; u < table.cols; ++u) {
      const auto i = static_cast<size_t>(u);
      const cv::Vec2f at = upper[i] * (1 - down) + lower[i] * down;
      table(v, u) = std::isfinite(at[0] + at[1]) ? at : cv::Vec2f(kNoPixel, kNoPixel);
    }
  }
  return table;
}

}  // namespace freelsd
