#include "engine/geometry/remap_table.h"

#include <cmath>
#include <limits>

namespace freelsd {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

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
  const float spacing = static_cast<float>(node_spacing_px);
  cv::Mat2f table(size);
  for (int v = 0; v < table.rows; ++v) {
    const int row = v / node_spacing_px;
    const float down = static_cast<float>(v % node_spacing_px) / spacing;
    for (int u = 0; u < table.cols; ++u) {
      const int col = u / node_spacing_px;
      const float along = static_cast<float>(u % node_spacing_px) / spacing;
      const cv::Vec2f upper = nodes(row, col) * (1 - along) + nodes(row, col + 1) * along;
      const cv::Vec2f lower = nodes(row + 1, col) * (1 - along) + nodes(row + 1, col + 1) * along;
      const cv::Vec2f at = upper * (1 - down) + lower * down;
      table(v, u) = std::isfinite(at[0] + at[1]) ? at : cv::Vec2f(kNoPixel, kNoPixel);
    }
  }
  return table;
}

}  // namespace freelsd
