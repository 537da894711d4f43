// Private to glide/: areas as the nodes of a grid that lie in them.
#pragma once

#include <vector>

#include <Eigen/Core>
#include <opencv2/core.hpp>

namespace freelsd {

// Nodes are the corners of cells: one row and one column more than the grid has. 255 is inside.
class NodeMask {
 public:
  NodeMask(int num_rows, int num_cols);

  // Sets the nodes around which the polygon winds. Where it overlaps itself, it does so in the same
  // sense, so the overlap is inside too. Places are columns and rows.
  void Fill(const std::vector<Eigen::Vector2d>& polygon);
  void Clear() { nodes_.setTo(0); }
  // Keeps only what is inside both.
  void Intersect(const NodeMask& other) { nodes_ &= other.nodes_; }
  // 255 in cells whose four nodes are inside.
  cv::Mat1b WholeCells() const;

 private:
  struct Crossing {
    double col = 0.0;
    int winding = 0;
  };

  void AddCrossings(const Eigen::Vector2d& begin, const Eigen::Vector2d& end);

  void FillRow(int row, std::vector<Crossing>& crossings);

  cv::Mat1b nodes_;
  // Where the polygon's edges cross each row; empty between calls.
  std::vector<std::vector<Crossing>> crossings_;
};

}  // namespace freelsd
