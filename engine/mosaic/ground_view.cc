#include "engine/mosaic/ground_view.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace freelsd {
namespace {

constexpr float kUnseen = std::numeric_limits<float>::quiet_NaN();

// Cells of the lattice's columns (or rows) between nodes.
struct Axis {
  // Node before each cell centre, and the centre's place between that node and the next, 0..1.
  std::vector<int> node;
  std::vector<float> share;
  // Number of the first node, counted from the origin.
  double first_node = 0.0;
  int num_nodes = 0;
};

// `origin`: any node. Coordinates of cell centres are (first + i + 0.5) * size. Nodes and shares of
// a place are the same in every rectangle that holds it, to the last bit.
Axis AxisOf(int first, int count, double size, double origin, double spacing) {
  const auto place_at = [&](int i) { return ((first + i + 0.5) * size - origin) / spacing; };
  Axis axis;
  axis.first_node = std::floor(place_at(0));
  for (int i = 0; i < count; ++i) {
    const double node = std::floor(place_at(i));
    axis.node.push_back(static_cast<int>(node - axis.first_node));
    axis.share.push_back(static_cast<float>(place_at(i) - node));
    axis.num_nodes = axis.node.back() + 2;
  }
  return axis;
}

cv::Mat2f Interpolated(const cv::Mat2f& nodes, const Axis& east, const Axis& south) {
  cv::Mat2f table(static_cast<int>(south.node.size()), static_cast<int>(east.node.size()));
  std::vector<cv::Vec2f> along(static_cast<size_t>(nodes.cols));
  for (int row = 0; row < table.rows; ++row) {
    const auto i = static_cast<size_t>(row);
    const float down = south.share[i];
    const cv::Vec2f* upper = nodes[south.node[i]];
    const cv::Vec2f* lower = nodes[south.node[i] + 1];
    for (int col = 0; col < nodes.cols; ++col) {
      along[static_cast<size_t>(col)] = upper[col] * (1.0f - down) + lower[col] * down;
    }
    cv::Vec2f* out = table[row];
    for (int col = 0; col < table.cols; ++col) {
      const auto j = static_cast<size_t>(col);
      const auto node = static_cast<size_t>(east.node[j]);
      const float right = east.share[j];
      const cv::Vec2f at = along[node] * (1.0f - right) + along[node + 1] * right;
      out[col] = std::isfinite(at[0] + at[1]) ? at : cv::Vec2f(kNoPixel, kNoPixel);
    }
  }
  return table;
}

}  // namespace

cv::Rect CellsOf(const Footprint& footprint, const LatticeRect& within) {
  const cv::Rect& cells = within.cells;
  const auto clamp = [&](double coordinate, int first, int count) {
    return static_cast<int>(
        std::clamp(coordinate / within.size_m, double(first), double(first + count)));
  };
  // Rounded outwards by one cell at least.
  const int west = clamp(footprint.min_in_world.x() - 2 * within.size_m, cells.x, cells.width);
  const int east = clamp(footprint.max_in_world.x() + 2 * within.size_m, cells.x, cells.width);
  const int north = clamp(-footprint.max_in_world.y() - 2 * within.size_m, cells.y, cells.height);
  const int south = clamp(-footprint.min_in_world.y() + 2 * within.size_m, cells.y, cells.height);
  return {cv::Point(west, north), cv::Point(east, south)};
}

GroundView::GroundView(const PictureGround& ground, const AdjustedBlock& block, size_t view)
    : ground_(ground),
      camera_(block.CameraOf(view)),
      position_in_world_(block.views[view].world_from_camera.translation),
      camera_from_world_(Inverse(block.views[view].world_from_camera)),
      footprint_(FootprintOf(camera_,
                             block.views[view].world_from_camera,
                             ground.LowestHeight(),
                             ground.HighestHeight())),
      sampling_m_(block.views[view].height_above_ground / block.camera.MeanFocalPx()) {}

cv::Rect GroundView::CellsWithin(const LatticeRect& within) const {
  return CellsOf(footprint_, within);
}

cv::Vec2f GroundView::ImageOfNode(const Eigen::Vector2d& place_in_world) const {
  const float height = ground_.HeightAt(place_in_world);
  if (std::isnan(height)) return {kUnseen, kUnseen};
  Eigen::Vector3d point_in_world;
  point_in_world << place_in_world, height;
  const auto pixel = camera_.ImageFromCamera(camera_from_world_ * point_in_world);
  if (!pixel) return {kUnseen, kUnseen};
  return {static_cast<float>(pixel->x()), static_cast<float>(pixel->y())};
}

cv::Mat2f GroundView::ImageOf(const LatticeRect& rect, double node_spacing_m) const {
  const Eigen::Vector2d center = ground_.grid().CellCenter(0, 0);
  const Axis east = AxisOf(rect.cells.x, rect.cells.width, rect.size_m, center.x(), node_spacing_m);
  const Axis south =
      AxisOf(rect.cells.y, rect.cells.height, rect.size_m, -center.y(), node_spacing_m);
  cv::Mat2f nodes(south.num_nodes, east.num_nodes);
  for (int row = 0; row < nodes.rows; ++row) {
    for (int col = 0; col < nodes.cols; ++col) {
      nodes(row, col) = ImageOfNode({center.x() + (east.first_node + col) * node_spacing_m,
                                     center.y() - (south.first_node + row) * node_spacing_m});
    }
  }
  return Interpolated(nodes, east, south);
}

}  // namespace freelsd
