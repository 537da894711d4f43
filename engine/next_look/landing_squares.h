// Private to next_look/: squares of ground, the landings that are tried in each, and the cells that
// each landing needs.
#pragma once

#include <optional>
#include <vector>

#include "engine/next_look/known_ground.h"
#include "engine/next_look/next_look.h"

namespace freelsd {

// Cells that must be known, as indices of a raster (row-major).
struct NeededCells {
  std::vector<int> cells;
  // With those outside the raster, which never become known.
  int num_cells = 0;

  double KnownShare(const cv::Mat1f& known) const;
};

// One touchdown with a final and a circle.
struct TriedLanding {
  Eigen::Vector3d touchdown_in_world = Eigen::Vector3d::Zero();
  // Probability that the landing is free if all its cells become known.
  double probability = 0.0;
  // Disc, ground roll and final; empty for an unverified site, whose path is known.
  NeededCells path;
  NeededCells circle;

  // Expected landing value.
  double ValueAt(const cv::Mat1f& known, const NextLookOptions& options) const;
};

// A square of ground that holds at most one landing, and has none that is landable yet.
struct LandingSquare {
  // Most probable first: no landing is worth more than its probability.
  std::vector<TriedLanding> landings;
  // The best site there.
  std::optional<size_t> site;
  // Around all needed cells.
  cv::Rect cells;

  // Of its best landing.
  double ValueAt(const cv::Mat1f& known, const NextLookOptions& options) const;
  const TriedLanding& BestAt(const cv::Mat1f& known, const NextLookOptions& options) const;
};

struct LandingSquares {
  // Squares in which a landing may become known.
  std::vector<LandingSquare> open;
  // Of the sites so far.
  double landing_value = 0.0;
};
LandingSquares FindSquares(const LookRequest& request,
                           const KnownGround& ground,
                           const NextLookOptions& options);

}  // namespace freelsd
