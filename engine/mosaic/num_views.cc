#include <algorithm>
#include <limits>

#include "engine/footprint/footprint.h"
#include "engine/mosaic/mosaic.h"

namespace freelsd {
namespace {

// Rows and columns of the grid that touch the footprint.
cv::Rect CellsOfGrid(const Footprint& footprint, const Grid& grid) {
  const Polygon corners{footprint.min_in_world, footprint.max_in_world};
  if (!footprint.min_in_world.allFinite()) return {0, 0, grid.num_cols, grid.num_rows};
  return grid.CellsAround(corners, grid.cell_size_m);
}

void CountView(const ElevationMap& map,
               const Camera& camera,
               const Rigid3d& camera_from_world,
               const cv::Rect& cells,
               cv::Mat1b& counts) {
  for (int row = cells.y; row < cells.y + cells.height; ++row) {
    for (int col = cells.x; col < cells.x + cells.width; ++col) {
      uint8_t& count = counts(row, col);
      if (!map.IsSeen(row, col) || count == std::numeric_limits<uint8_t>::max()) continue;
      Eigen::Vector3d point_in_world;
      point_in_world << map.grid.CellCenter(row, col), map.elevation(row, col);
      const auto pixel = camera.ImageFromCamera(camera_from_world * point_in_world);
      if (pixel && camera.IsInside(*pixel)) ++count;
    }
  }
}

}  // namespace

cv::Mat1b NumViewsOf(const ElevationMap& map, const AdjustedBlock& block) {
  if (map.elevation.empty()) return {};
  cv::Mat1b counts(map.elevation.size(), uint8_t{0});
  const HeightRange heights = HeightRangeOf(map.elevation);
  if (heights.IsEmpty()) return counts;
  for (size_t v = 0; v < block.views.size(); ++v) {
    if (!block.views[v].is_connected) continue;
    const Rigid3d& world_from_camera = block.views[v].world_from_camera;
    const Camera camera = block.CameraOf(v);
    const Footprint footprint =
        FootprintOf(camera, world_from_camera, heights.lowest_m, heights.highest_m);
    CountView(map, camera, Inverse(world_from_camera), CellsOfGrid(footprint, map.grid), counts);
  }
  return counts;
}

}  // namespace freelsd
