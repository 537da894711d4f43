// Where in a region a touchdown is worth a check.
#pragma once

#include <vector>

#include "engine/approach/approach.h"

namespace freelsd {

struct Candidate {
  cv::Point cell;  // x = col, y = row
  Eigen::Vector3d touchdown_in_world = Eigen::Vector3d::Zero();
  double hazard_distance = 0.0;
};

// Cells of the footprint far enough from any hazard, farthest first, at least candidate_spacing_m
// apart; equal distances in order of row and column.
std::vector<Candidate> TouchdownCandidates(const ElevationMap& map,
                                           const HazardLayers& hazards,
                                           const PlanRequest& request,
                                           const Aircraft& aircraft,
                                           const ApproachOptions& options);

// The seen cell of the footprint farthest from any hazard; nothing where no cell was seen.
std::optional<Candidate> LeastBadCell(const ElevationMap& map,
                                      const HazardLayers& hazards,
                                      const PlanRequest& request);

// Whether any seen cell of the footprint is grass.
bool HasGrass(const HazardLayers& hazards, const PlanRequest& request);

// Worst slope and roughness within the touchdown disc; NaN where nothing is known.
struct Ground {
  double slope = 0.0;
  double roughness = 0.0;
};
Ground GroundAround(const HazardLayers& hazards,
                    const Eigen::Vector2d& touchdown_in_world,
                    double radius);

// Distance to hazard that a touchdown needs (spec 3.6).
double NeededHazardDistance(const Grid& grid,
                            const Aircraft& aircraft,
                            const ApproachOptions& options);

}  // namespace freelsd
