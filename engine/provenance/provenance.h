// Input: adjusted views, the pairs that were matched, a place. Output: the photographs that a cell
// of the map comes from, and how much each says about its height. Not in the paper.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "engine/stereo/stereo.h"

namespace freelsd {

struct ProvenanceOptions {
  // The layers of a cell read the map and the photographs this far around it; its distance to the
  // nearest hazard reads this far beyond that hazard.
  double context_m = 60.0;
  double beyond_hazard_m = 30.0;

  double ContextFor(double hazard_distance_m) const;
  // Throws std::invalid_argument: "provenance.context_m = -1: must be in [0, 1000]".
  void Check() const;
};

struct SourceView {
  // Index into AdjustedBlock::views.
  size_t view = 0;
  // Where the photograph shows the place.
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  // Share of what all pairs that show the place say about its height: the inverse variance of a
  // height is that of the disparity times the squared baseline over height, over the squared size
  // of a pixel on the ground.
  double weight = 0.0;
};

struct Provenance {
  // Photographs that show the place; the most weighty first.
  std::vector<SourceView> sources;
  // Indices of the others that the cell depends on: they show ground around it, or were matched
  // with one that does. Ascending.
  std::vector<size_t> context;
};

// `hazard_distance_m`: of the place, as in HazardLayers. Connected views count. The same input
// gives the same result.
Provenance ProvenanceOf(const Eigen::Vector3d& place_in_world,
                        const AdjustedBlock& block,
                        const std::vector<StereoPair>& pairs,
                        double hazard_distance_m,
                        const ProvenanceOptions& options);

}  // namespace freelsd
