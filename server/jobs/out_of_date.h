// Private to jobs/: what a new evaluation of a flight makes out of date.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "server/jobs/evaluation.h"

namespace freelsd {

// The flight's stored sites that the new ones replace: those of the same regions, and those outside
// all regions on the ground of the new maps.
std::vector<std::string> OutOfDateSites(const std::vector<SiteRow>& stored,
                                        const std::vector<SiteRow>& sites,
                                        const std::vector<FlightMapRow>& maps,
                                        EvaluationScope scope);

// The flight's maps that no site needs any more and that the new ones replace.
std::vector<std::string> OutOfDateMaps(const std::vector<FlightMapRow>& stored,
                                       const std::vector<FlightMapRow>& added,
                                       const std::set<std::string>& needed,
                                       EvaluationScope scope);

}  // namespace freelsd
