#include "tests/evaluation/watch/stored_ground.h"

#include <cmath>

#include "api/stored/map/map.h"

namespace freelsd {

StoredGround::StoredGround(const ElevationMap& map,
                           const AdjustedBlock& block,
                           const ImageSource& images,
                           const MosaicOptions& options)
    : map_(map) {
  const MosaicLattice lattice = PlanMosaic(map, block, options);
  const int side_px = lattice.tile_size_px;
  picture_ = cv::Mat4b(lattice.tiles.size() * side_px, cv::Vec4b::all(0));
  grid_.cell_size_m = lattice.pixel_size_m;
  grid_.north_west_in_world =
      lattice.TileSideM(0) * Eigen::Vector2d(lattice.tiles.x, -lattice.tiles.y);
  grid_.num_rows = picture_.rows;
  grid_.num_cols = picture_.cols;
  MakeMosaic(map, block, images, options, [&](const MosaicTile& tile) {
    if (tile.level != 0) return;
    const cv::Point at = (cv::Point(tile.col, tile.row) - lattice.tiles.tl()) * side_px;
    DeserializePhotoTile(SerializePhotoTile(tile.image))
        .copyTo(picture_(cv::Rect(at, tile.image.size())));
  });
}

StripPicture StoredGround::Around(const std::vector<Polygon>& outlines,
                                  const WatchOptions& options) const {
  Polygon corners;
  for (const Polygon& outline : outlines) {
    corners.insert(corners.end(), outline.begin(), outline.end());
  }
  const double reach_m = options.context_m + options.max_offset_m;
  const cv::Rect cells =
      grid_.CellsAround(corners, reach_m) & cv::Rect(0, 0, grid_.num_cols, grid_.num_rows);
  StripPicture strip;
  strip.grid = grid_.Part(cells);
  strip.picture = picture_(cells);
  strip.ground_grid = map_.grid;
  strip.elevation = map_.elevation;
  strip.upper = map_.upper;
  strip.outlines = outlines;
  return strip;
}

std::vector<Polygon> OutlinesOf(const Eigen::Vector2d& touchdown_in_world,
                                double disc_radius_m,
                                const std::vector<Eigen::Vector3d>& ground_roll_in_world) {
  constexpr int kNumCorners = 24;
  Polygon disc, roll;
  for (int i = 0; i < kNumCorners; ++i) {
    disc.push_back(touchdown_in_world + disc_radius_m * DirectionOf(-2.0 * kPi * i / kNumCorners));
  }
  for (const Eigen::Vector3d& corner : ground_roll_in_world) roll.push_back(corner.head<2>());
  std::vector<Polygon> outlines{disc};
  if (!roll.empty()) outlines.push_back(roll);
  return outlines;
}

}  // namespace freelsd
