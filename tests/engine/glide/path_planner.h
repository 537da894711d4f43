// The reference for the ground in reach: the paths to one place, checked metre by metre.
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
  // No ground is lower.
  double lowest_height = 0.0;

  // The assumed height where nothing is known.
  double HeightAt(const Eigen::Vector2d& place) const;
};

// Each turn to one side, of at most a whole circle, and straight flight that end over the place no
// later than `last_time`.
std::vector<Transit> TransitsTo(const TransitTask& task,
                                const Performance& performance,
                                double last_time);

// Whether, in every wind and from every heading, one of these paths clears the ground and arrives
// with enough height.
bool IsReached(const GlideStart& start,
               const Eigen::Vector2d& place,
               const FineGround& ground,
               const Aircraft& aircraft,
               const ReachLimits& limits);

}  // namespace freelsd
