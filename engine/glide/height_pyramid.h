// Private to glide/: finds where a sloping line first comes too near to the ground.
#pragma once

#include <array>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core.hpp>

namespace freelsd {

// The middle of a narrow sector. Places are columns and rows, continuous: (0, 0) is the outer
// corner of the cell (0, 0). Lengths are metres along the line in the frame of the air.
struct SlopingLine {
  Eigen::Vector2d begin = Eigen::Vector2d::Zero();
  Eigen::Vector2d step_per_metre = Eigen::Vector2d::Zero();
  double height = 0.0;
  double loss_per_metre = 0.0;
  double length = 0.0;
};

struct ClearWay {
  // Up to here the line keeps the clearance.
  double length = 0.0;
  // Stretches before that, where it does not keep the wanted height: begin and end.
  std::vector<std::pair<double, double>> low;
  // Blocks that were looked at.
  int num_steps = 0;
};

// Highest ground in blocks of cells of several sizes. A sector is checked by its middle line alone,
// because each cell holds the highest ground of its neighbours too: the sector must reach no
// farther than `margin_cells` to each side.
class HeightPyramid {
 public:
  HeightPyramid(const cv::Mat1f& top, int margin_cells);

  // `wanted` is at least `clearance`.
  ClearWay ClearWayAlong(const SlopingLine& line, double clearance, double wanted) const;
  // Whether a point keeps the clearance; false outside the grid. Column and row as above.
  bool IsClear(const Eigen::Vector2d& place, double height, double clearance) const;

 private:
  static constexpr int kNumLevels = 4;
  std::array<cv::Mat1f, kNumLevels> levels_;
};

}  // namespace freelsd
