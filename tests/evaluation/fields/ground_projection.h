// Input: the adjusted views of a run and heights of the ground. Output: where the pixels of its
// photographs lie on the ground.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "engine/adjustment/adjustment.h"
#include "tests/evaluation/fields/ground_heights.h"
#include "tests/evaluation/fields/outlines.h"

namespace freelsd {

// Keeps a reference to the block, which must outlive it.
class GroundProjection {
 public:
  GroundProjection(const AdjustedBlock& block, GroundHeights heights);

  // Connected view whose frame_id, without an extension, is this.
  std::optional<size_t> ViewOf(const std::string& photograph) const;
  const GroundHeights& heights() const { return heights_; }
  // Where the pixel's ray is `raise` metres above the ground. Nothing for a ray that does not
  // descend to it.
  std::optional<Eigen::Vector3d> GroundAt(size_t view,
                                          const Eigen::Vector2d& point_in_image,
                                          double raise = 0.0) const;
  // Of all corners, and of points between them: a straight edge in an image is not straight on
  // uneven ground. Nothing if the photograph has no connected view or a corner misses the ground.
  std::optional<Polygon> OnGround(const Outline& outline, double raise = 0.0) const;

 private:
  const AdjustedBlock& block_;
  GroundHeights heights_;
  std::map<std::string, size_t> views_;
};

}  // namespace freelsd
