// Private to the renderer: the surface of a world, and where rays from above meet it. Places are in
// cells (fractional, from the first cell's centre), heights in metres.
#pragma once

#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <opencv2/core.hpp>

namespace freelsd {

struct HeightRange {
  float bottom = 0.0f;
  float top = 0.0f;
};

// A ray that goes down: where it is at the height `top`, by how many cells it moves sideways per
// metre of descent, and how deep it can go before it has surely met the surface.
struct DescentRay {
  Eigen::Vector2f entry = Eigen::Vector2f::Zero();
  Eigen::Vector2f slide = Eigen::Vector2f::Zero();
  float top = 0.0f;
  float limit = 0.0f;

  Eigen::Vector2f CellAt(float depth) const { return entry + depth * slide; }
};

// Through the layer of heights that rays from `origin` (cells, metres) can meet; `slide` in cells
// per metre of descent.
DescentRay DescentThrough(const HeightRange& layer,
                          const Eigen::Vector3d& origin,
                          const Eigen::Vector2d& slide);

class HeightField {
 public:
  // Keeps the grid, which must not change.
  explicit HeightField(const cv::Mat1f& surface);

  // Heights between which all rays from `origin` whose slides lie in the box meet the surface:
  // down to the top of it none does, at the bottom of it all have.
  HeightRange LayerMetBy(const Eigen::Vector3d& origin, const Eigen::AlignedBox2d& slides) const;

  // Metres below `ray.top` at which the ray first meets the surface.
  float HitDepth(const DescentRay& ray) const;

 private:
  // Lowest and highest cell of every square block.
  struct Level {
    int side = 0;
    cv::Mat1f bottom, top;
  };

  // A depth and by how much the ray is above the surface there.
  struct Trial {
    float depth = 0.0f;
    float clearance = 0.0f;
  };

  HeightRange RangeIn(const cv::Rect& cells) const;
  Trial Try(const DescentRay& ray, float depth) const;
  float CloseIn(const DescentRay& ray, Trial above, Trial below) const;

  cv::Mat1f surface_;
  HeightRange all_;
  std::vector<Level> levels_;  // fine to coarse
  // Highest cell that a ray within a block can meet: of the block and a margin.
  cv::Mat1f block_top_;
};

}  // namespace freelsd
