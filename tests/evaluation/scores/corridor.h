// Input: a world and the line of a final. Output: the highest thing across the aircraft's width,
// for every place of the line and of its parallels.
#pragma once

#include <opencv2/core.hpp>

#include "tests/evaluation/scores/obstruction.h"

namespace freelsd {

// Horizontal axes of a final: forward is the landing direction, left is to the left of it.
struct FinalFrame {
  Eigen::Vector2d touchdown_in_world = Eigen::Vector2d::Zero();
  Eigen::Vector2d forward = Eigen::Vector2d::UnitX();

  Eigen::Vector2d Left() const { return {-forward.y(), forward.x()}; }
  Eigen::Vector2d Place(double along, double across) const {
    return touchdown_in_world + along * forward + across * Left();
  }
};

// Part of the frame, metres: along from `first` to `last`, across up to `reach` to either side.
struct CorridorExtent {
  double first = 0.0;
  double last = 0.0;
  double reach = 0.0;
  double half_width = 0.0;
};

// Samples are at most half a cell of the world apart.
class Corridor {
 public:
  Corridor(const World& world,
           const FinalFrame& frame,
           const CorridorExtent& extent,
           ThinThings thin);

  int num_rows() const { return highest_.rows; }
  double Along(int row) const { return extent_.first + row * step_along_; }
  // First row that is not before a place.
  int RowAt(double along) const;
  // World z of the highest thing within half_width of a place. `across` is rounded to a sample.
  float Highest(int row, double across) const;
  // The places that Highest looks at.
  std::vector<Eigen::Vector2d> PlacesAcross(int row, double across) const;

 private:
  int ColAt(double across) const;

  FinalFrame frame_;
  CorridorExtent extent_;
  double step_along_ = 0.0;
  double step_across_ = 0.0;
  // Samples in half_width, and in reach.
  int num_half_ = 0;
  int num_reach_ = 0;
  cv::Mat1f highest_;
};

}  // namespace freelsd
