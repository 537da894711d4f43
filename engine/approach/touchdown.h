// Private to approach/: selects touchdown places within the region.
#pragma once

#include <optional>
#include <vector>

#include "engine/approach/approach.h"

namespace freelsd {

struct Touchdown {
  // Cell of the map.
  int row = 0;
  int col = 0;
  Eigen::Vector3d place_in_world = Eigen::Vector3d::Zero();
  double hazard_distance = 0.0;
};

// Throws std::invalid_argument when map and hazards have different grids.
void RequireOneGrid(const ElevationMap& map, const HazardLayers& hazards);

// Standard deviation of the map's position, at least min_map_position_sd_m. NaN if unknown.
double PositionDeviation(const ElevationMap& map, const ApproachOptions& options);

// Adds a margin for the map's position error to the ground roll and to the corridor's half-width.
Aircraft WithPositionMargin(Aircraft aircraft,
                            const ElevationMap& map,
                            const ApproachOptions& options);

// A touchdown at the centre of a seen cell.
Touchdown TouchdownAt(const ElevationMap& map, const HazardLayers& hazards, const cv::Point& cell);

// The cells within the footprint.
struct FootprintContent {
  // Seen cells, farthest from hazard first. Of cells at equal distance, the one nearer to the
  // middle is first.
  std::vector<Touchdown> touchdowns;
  bool has_grass = false;
};
FootprintContent ReadFootprint(const ElevationMap& map,
                               const HazardLayers& hazards,
                               const Polygon& footprint);

// True if a touchdown is far enough from hazard. False if one of the two distances is NaN.
inline bool IsFarEnough(double hazard_distance, double required_distance) {
  return hazard_distance >= required_distance;
}

// Places far enough from hazard, safest first. Each list covers all usable ground. If all
// candidates were near the safest place, one house below their finals would reject the whole field.
struct TouchdownCandidates {
  // At most max_num_candidates.
  std::vector<Touchdown> first;
  // More densely spaced, at most max_num_reserve_candidates: for fields with room for only one
  // final.
  std::vector<Touchdown> reserve;
};
TouchdownCandidates SelectCandidates(const std::vector<Touchdown>& touchdowns,
                                     double required_distance,
                                     double cell_size,
                                     const ApproachOptions& options);

// Largest value of a layer within the disc around a touchdown; NaN if all of it is unseen.
double LargestInDisc(const cv::Mat1f& layer,
                     const Touchdown& touchdown,
                     double radius,
                     double cell_size);

}  // namespace freelsd
