// From a map to its hazard layers in one call, with what covers it.
#pragma once

#include <vector>

#include "engine/hazard/hazard.h"

namespace freelsd {

inline HazardLayers AssessHazards(const ElevationMap& map,
                                  const std::vector<KindView>& kind_views,
                                  const HazardLimits& limits,
                                  const HazardOptions& options,
                                  const Orthophoto& photo = {}) {
  const GroundSurface surface = MeasureSurface(map, options.surface);
  const GroundCover cover = AssessCover(map, surface, kind_views, options.cover, photo);
  return AssessHazards(map, surface, cover, limits, options).layers;
}

}  // namespace freelsd
