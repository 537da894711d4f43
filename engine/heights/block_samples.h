// Private to heights/. Resamples the views of a block of ground at one height.
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core.hpp>

namespace freelsd {

// Position in a photograph of a corner of the block, by its height: quadratic in `lift`, -1 .. 1 of
// the range of heights. Within 0.001 pixels of the projection.
struct LiftedCorner {
  Eigen::Vector2d middle, slope, bend;
  Eigen::Vector2d At(double lift) const { return middle + lift * (slope + lift * bend); }
};

struct LiftedView {
  const cv::Mat1f* detail = nullptr;
  // North-west, north-east, south-west, south-east.
  std::array<LiftedCorner, 4> corners;
};

// The samples of a block: a square, evenly spread.
class SamplePattern {
 public:
  explicit SamplePattern(int side);
  int side() const { return side_; }
  int count() const { return side_ * side_; }

  static constexpr int kMaxSide = 32;
  using Samples = std::array<float, kMaxSide * kMaxSide>;
  // Shares of the way east and south, row by row, and their product.
  Samples east{}, south{}, both{};

 private:
  int side_;
};

// Where the answer for the samples of a block is written.
struct BlockOutput {
  // Variance between views, without bias, and mean square.
  cv::Mat1f variance, power;
};

// Two views or more.
void CompareViews(const std::vector<LiftedView>& views,
                  double lift,
                  const SamplePattern& pattern,
                  BlockOutput output);

}  // namespace freelsd
