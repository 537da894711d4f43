// The tiles of a mosaic, kept, and looked up by place.
#pragma once

#include <cmath>
#include <map>
#include <tuple>

#include "engine/mosaic/mosaic.h"

namespace freelsd {

struct KeptTiles {
  MosaicReport report;
  std::map<std::tuple<int, int, int>, cv::Mat4b> images;  // level, row, col

  // Colour of the pixel that holds the place; transparent where no tile is.
  cv::Vec4b At(const Eigen::Vector2d& place, int level = 0) const {
    const double size_m = report.lattice.pixel_size_m * (1 << level);
    const int side = report.lattice.tile_size_px;
    const int col = static_cast<int>(std::floor(place.x() / size_m));
    const int row = static_cast<int>(std::floor(-place.y() / size_m));
    const auto divide = [side](int at) { return static_cast<int>(std::floor(double(at) / side)); };
    const auto found = images.find({level, divide(row), divide(col)});
    if (found == images.end()) return cv::Vec4b::all(0);
    return found->second(row - divide(row) * side, col - divide(col) * side);
  }
};

inline KeptTiles Kept(const ElevationMap& map,
                      const AdjustedBlock& block,
                      const ImageSource& images,
                      const MosaicOptions& options = {}) {
  KeptTiles kept;
  kept.report = MakeMosaic(map, block, images, options, [&kept](const MosaicTile& tile) {
    kept.images[{tile.level, tile.row, tile.col}] = tile.image.clone();
  });
  return kept;
}

// Calls visit(place, color) for the middle of each pixel in a square around the origin.
template <typename Visit>
void ForEachPixel(const KeptTiles& kept, double half_side_m, Visit visit) {
  const double size_m = kept.report.lattice.pixel_size_m;
  const int reach = static_cast<int>(half_side_m / size_m);
  for (int row = -reach; row < reach; ++row) {
    for (int col = -reach; col < reach; ++col) {
      const Eigen::Vector2d place((col + 0.5) * size_m, -(row + 0.5) * size_m);
      visit(place, kept.At(place));
    }
  }
}

}  // namespace freelsd
