// Private to next_look/: which cells the photographs of a straight leg show, and how often.
#pragma once

#include <vector>

#include "engine/next_look/next_look.h"

namespace freelsd {

// Where a photograph shows flat ground below it, in metres along the leg and to its right.
class PhotoShape {
 public:
  // The aircraft flies level at this height above ground, its nose along the leg.
  PhotoShape(const Rig& rig, double height_above_ground_m);

  // Of the whole photograph: along, across.
  const Eigen::Vector2d& min() const { return min_; }
  const Eigen::Vector2d& max() const { return max_; }
  Eigen::Vector2d Extent() const { return max_ - min_; }
  // Photographs that show a place, of a leg of this length that begins at along = 0.
  int NumViewsAt(const Eigen::Vector2d& along_right, double length_m, double spacing_m) const;

 private:
  static constexpr double kStepM = 2.0;
  // First and last place along the leg, for steps across it.
  std::vector<Eigen::Vector2d> along_;
  Eigen::Vector2d min_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d max_ = Eigen::Vector2d::Zero();
};

// A leg on the ground.
struct LegLine {
  Eigen::Vector2d from_in_world = Eigen::Vector2d::Zero();
  double heading = 0.0;
  double length_m = 0.0;

  Eigen::Vector2d To() const { return from_in_world + length_m * DirectionOf(heading); }
};

// Number of new photographs in some cells of a grid.
struct LegViews {
  cv::Rect cells;
  cv::Mat1f num_views;
};
LegViews ViewsOf(const LegLine& leg, const PhotoShape& shape, double spacing_m, const Grid& grid);

}  // namespace freelsd
