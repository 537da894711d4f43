// Input: a photograph with a pose whose error is a few metres on the ground. Output: the photograph
// projected onto the ground, north up, so that photographs of any heading and tilt are comparable.
#pragma once

#include <optional>

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "engine/tracks/tracks.h"

namespace freelsd {

struct GroundImage {
  cv::Mat grey;
  // Centre of the top-left pixel, world.
  Eigen::Vector2d north_west = Eigen::Vector2d::Zero();
  double pixel_m = 0.0;
  double ground_z = 0.0;

  Eigen::Vector3d WorldFromPixel(const Eigen::Vector2d& pixel) const {
    return {north_west.x() + pixel_m * pixel.x(), north_west.y() - pixel_m * pixel.y(), ground_z};
  }
  Eigen::Vector2d PixelFromWorld(const Eigen::Vector2d& place) const {
    return {(place.x() - north_west.x()) / pixel_m, (north_west.y() - place.y()) / pixel_m};
  }
};

// Assumes level ground, height_above_ground below the view. `camera` is the camera of this view,
// with this view's readout. The resolution is that of the photograph, after reduction to at most
// width_px columns. `grey` is empty if the camera does not look down.
GroundImage SeenFromAbove(const View& view,
                          const Camera& camera,
                          const cv::Mat& image,
                          int width_px);

}  // namespace freelsd
