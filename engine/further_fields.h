// Ground within a region's rectangle on which one may land besides its site. Private to the
// pipeline.
#pragma once

#include <functional>
#include <vector>

#include "engine/pipeline.h"

namespace freelsd {

// Pieces of ground within a region on which the touchdown disc fits, each as a region of its own:
// the rectangle around it, everything else as observed. What hangs together is cut into pieces of
// at most that extent, for a border that the map does not show may part it. Widest first.
std::vector<Region> FurtherFields(const Region& region,
                                  const Evaluation& evaluation,
                                  double required_hazard_distance,
                                  double max_extent_m);

// Adds to the sites, one per region, those further fields of accepted ones on which one can land,
// planned by `plan`; none near a site that is already there, be it of another region.
void AddFurtherSites(Evaluation& evaluation,
                     const Aircraft& aircraft,
                     const PipelineOptions& options,
                     const std::function<Site(const Region& field)>& plan);

}  // namespace freelsd
