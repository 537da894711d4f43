// Private to approach/: where within the region to touch down.
#pragma once

#include <optional>
#include <vector>

#include "engine/approach/approach.h"

namespace freelsd {

struct Touchdown {
  // Of the map.
  int row = 0;
  int col = 0;
  Eigen::Vector3d place_in_world = Eigen::Vector3d::Zero();
  double hazard_distance = 0.0;
};

// Throws std::invalid_argument when map and hazards are not of one grid.
void RequireOneGrid(const ElevationMap& map, const HazardLayers& hazards);

// With a ground roll and corridor that hold what may stand there, wherever the map really lies.
Aircraft WithPositionMargin(Aircraft aircraft,
                            const ElevationMap& map,
                            const ApproachOptions& options);

// What the footprint holds.
struct FootprintContent {
  // Seen cells, farthest from hazard first; equal ones nearer to the middle first.
  std::vector<Touchdown> touchdowns;
  bool has_grass = false;
};
FootprintContent ReadFootprint(const ElevationMap& map,
                               const HazardLayers& hazards,
                               const Polygon& footprint,
                               const ApproachOptions& options);

// Places far enough from hazard, each list safest first and spread over all of the ground where one
// could touch down: around the safest place alone, one house on its final would refuse the field.
struct TouchdownCandidates {
  // At most max_num_candidates.
  std::vector<Touchdown> first;
  // Closer together, at most max_num_reserve_candidates: for fields with room for one final only.
  std::vector<Touchdown> reserve;
};
TouchdownCandidates SelectCandidates(const std::vector<Touchdown>& touchdowns,
                                     double required_distance,
                                     double cell_size,
                                     const ApproachOptions& options);

// Largest value of a layer within the disc about a touchdown; NaN if all of it is unseen.
double LargestInDisc(const cv::Mat1f& layer,
                     const Touchdown& touchdown,
                     double radius,
                     double cell_size);

}  // namespace freelsd
