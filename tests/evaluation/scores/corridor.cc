#include "tests/evaluation/scores/corridor.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

namespace freelsd {

Corridor::Corridor(const World& world,
                   const FinalFrame& frame,
                   const CorridorExtent& extent,
                   ThinThings thin)
    : frame_(frame), extent_(extent), step_along_(StepOf(world)) {
  num_half_ = static_cast<int>(std::ceil(extent.half_width / StepOf(world)));
  // The outermost samples are at the wing tips.
  step_across_ = num_half_ == 0 ? StepOf(world) : extent.half_width / num_half_;
  num_reach_ = static_cast<int>(std::ceil(extent.reach / step_across_));
  const int num_rows = RowAt(extent.last) + 1;
  const int num_side = num_reach_ + num_half_;
  cv::Mat1f tops(num_rows, 2 * num_side + 1);
  for (int row = 0; row < tops.rows; ++row) {
    for (int col = 0; col < tops.cols; ++col) {
      const Eigen::Vector2d place = frame.Place(Along(row), (col - num_side) * step_across_);
      tops(row, col) = static_cast<float>(TopOf(world, place, thin));
    }
  }
  cv::dilate(tops, highest_, cv::Mat1b::ones(1, 2 * num_half_ + 1));
}

int Corridor::RowAt(double along) const {
  constexpr double kTolerance = 1e-9;
  return std::max(0,
                  static_cast<int>(std::ceil((along - extent_.first) / step_along_ - kTolerance)));
}

int Corridor::ColAt(double across) const {
  const int sample = static_cast<int>(std::lround(across / step_across_));
  return std::clamp(sample, -num_reach_, num_reach_) + num_reach_ + num_half_;
}

float Corridor::Highest(int row, double across) const { return highest_(row, ColAt(across)); }

std::vector<Eigen::Vector2d> Corridor::PlacesAcross(int row, double across) const {
  const int middle = ColAt(across) - num_reach_ - num_half_;
  std::vector<Eigen::Vector2d> places;
  places.reserve(static_cast<size_t>(2 * num_half_ + 1));
  for (int i = middle - num_half_; i <= middle + num_half_; ++i) {
    places.push_back(frame_.Place(Along(row), i * step_across_));
  }
  return places;
}

}  // namespace freelsd
