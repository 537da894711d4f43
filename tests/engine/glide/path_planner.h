// The reference for the ground in reach: one path for one place, checked metre by metre.
#pragma once

#include <optional>
#include <vector>

#include "engine/glide/glide.h"
#include "engine/glide/transit.h"

namespace freelsd {

// Heights of the ground in small cells; NaN where unseen. Places outside are unseen too.
struct FineGround {
  Grid grid;
  cv::Mat1f top;
  // Taken for unseen ground.
  double assumed_height = 0.0;

  // The assumed height where nothing is known.
  double HeightAt(const Eigen::Vector2d& place) const;
};

// A turn to one side and a straight flight that end over the place. Nothing if there is none. The
// turn is the shortest that leads there (ShortestTurns, with the final heading left free).
std::optional<Transit> ShortestTransit(const TransitTask& task, const Performance& performance);

// Whether the path of every wind and heading clears the ground and arrives with enough height.
bool IsReached(const GlideStart& start,
               const Eigen::Vector2d& place,
               const FineGround& ground,
               const Aircraft& aircraft,
               const ReachLimits& limits);

}  // namespace freelsd
