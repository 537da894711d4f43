// Private to map/. Where the pixels of a picture lie in world.
#pragma once

#include <functional>
#include <vector>

#include "api/export/map/map.h"

namespace freelsd {

// Place of the plane z = 0 of world at a latitude and longitude. The altitude is ignored.
Eigen::Vector2d PlaceInWorld(const GeoPoint& place, const LocalFrame& local_frame);

// A picture. Position (0, 0) is the outer corner of its north-western pixel, (1, 1) the opposite
// corner of that pixel.
struct PictureFrame {
  std::function<GeoPoint(const Eigen::Vector2d& position)> geo_from_position;
  // About, on the ground.
  double pixel_size_m = 1.0;
};

// Projects every 16th position and interpolates between them. The error is below a tenth of a
// pixel, because the axes of the picture turn little over 16 pixels; very large pixels are all
// projected.
class PixelPlaces {
 public:
  // Places of the pixels in `box`.
  PixelPlaces(const PictureFrame& picture, const cv::Rect& box, const LocalFrame& local_frame);
  const cv::Rect& box() const { return box_; }
  double pixel_size_m() const { return pixel_size_m_; }
  // Extent of the largest pixel along the axes of world: |east| + |north| of a side of it. For a
  // picture that is turned it is larger than the side.
  double PixelExtentM() const;
  // Box around the places, with a margin for the neighbours of cells.
  WorldBox BoxInWorld() const;
  // Places of `count` positions from west to east, `step` pixels apart.
  std::vector<Eigen::Vector2d> Row(const Eigen::Vector2d& first, double step, int count) const;

 private:
  Eigen::Vector2d Node(int row, int col) const { return nodes_[row * num_cols_ + col]; }

  cv::Rect box_;
  double pixel_size_m_;
  int spacing_px_;
  int num_rows_;
  int num_cols_;
  std::vector<Eigen::Vector2d> nodes_;
};

}  // namespace freelsd
