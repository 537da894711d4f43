// The stored strip and a photograph of it as rasters of equal pixels.
#pragma once

#include <functional>
#include <optional>

#include <opencv2/core.hpp>

#include "engine/watch/watch.h"

namespace freelsd {

// Heights of the stored ground. Keeps a reference to the strip.
class StripGround {
 public:
  explicit StripGround(const StripPicture& strip);

  // Bilinear between cell centres, metres. Holes have the heights of their surroundings. Beyond the
  // grid, its edge repeats.
  double HeightAt(const Eigen::Vector2d& place_in_world) const;
  // Does something stored, higher than the line of sight by `hidden_height_m`, hide the ground?
  bool IsHidden(const Eigen::Vector2d& place_in_world,
                const Eigen::Vector3d& eye_in_world,
                double hidden_height_m) const;
  bool IsEmpty() const { return height_.empty(); }

 private:
  const StripPicture& strip_;
  cv::Mat1f height_;
  double highest_ = 0.0;
};

// The stored picture around the strip.
struct StripCanvas {
  Grid grid;
  cv::Mat3f picture;  // BGR, 0..255
  cv::Mat1b is_shown;
  cv::Mat1b is_strip;

  // Place of a fractional pixel; whole numbers are centres.
  Eigen::Vector2d PlaceAt(double col, double row) const;
};
// `sampling_m`: of the photograph. The picture is not made much coarser than that.
StripCanvas MakeCanvas(const StripPicture& strip, double sampling_m, const WatchOptions& options);

// Centre of the box around the outlines, and the distance to its corners.
struct StripExtent {
  Eigen::Vector2d low, high;
  Eigen::Vector2d Middle() const { return 0.5 * (low + high); }
};
StripExtent ExtentOf(const StripPicture& strip);

// Displacement on the canvas, in pixels, at a pixel.
using Displacement = std::function<Eigen::Vector2d(double col, double row)>;

// A photograph projected onto the stored ground.
struct ProjectedPhoto {
  cv::Mat3f picture;
  cv::Mat1b is_shown;
};
ProjectedPhoto Project(const WatchedPhoto& photo,
                       const StripGround& ground,
                       const StripCanvas& canvas,
                       const Displacement& displacement);

// Length on the ground of a pixel of the photograph at a place, along its coarser direction;
// nothing where the photograph does not show the place.
std::optional<double> SamplingAt(const WatchedPhoto& photo,
                                 const StripGround& ground,
                                 const Eigen::Vector2d& place_in_world);

// 255 where the photograph is fine enough, and nothing that is stored hides the strip from it.
cv::Mat1b ComparableGround(const StripCanvas& canvas,
                           const StripGround& ground,
                           const WatchedPhoto& photo,
                           const WatchOptions& options);

}  // namespace freelsd
