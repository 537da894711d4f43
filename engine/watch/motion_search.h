// Where a photograph with an inexact pose may show the stored ground: turns and shifts of the whole
// picture.
#pragma once

#include <vector>

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "engine/watch/strip_canvas.h"

namespace freelsd {

// From the canvas to where the photograph shows it, pixels of the canvas.
using Motion = Eigen::Matrix<double, 2, 3>;

// Two pictures' patterns at a pixel of about `pixel_m`.
struct Patterns {
  // Of brightness, and of green against red and blue, which the light changes less.
  cv::Mat2f stored, seen;
  cv::Mat1b is_stored, is_seen;
  // Of the canvas to these pixels.
  double scale = 1.0;
};

Patterns PatternsOf(const StripCanvas& canvas, const ProjectedPhoto& photo, double pixel_m);

struct ScoredMotion {
  Motion motion = Motion::Identity();
  // Correlation; larger shifts are less likely.
  double score = 0.0;
};

class MotionSearch {
 public:
  MotionSearch(const StripCanvas& canvas, const ProjectedPhoto& photo, const WatchOptions& options);

  // Shifts up to max_offset_m after the photograph is turned and scaled about the middle of the
  // picture, best first.
  std::vector<ScoredMotion> WithTurn(double turn_deg, double scale) const;

 private:
  Patterns patterns_;
  int reach_px_ = 0;
};

}  // namespace freelsd
