#include "engine/selection/selection.h"

namespace freelsd {

PlanRequest RequestOf(const Candidate& candidate, int min_num_observations) {
  const Region& region = candidate.region;
  PlanRequest request;
  request.footprint = region.Footprint();
  request.area_m2 = region.area_m2;
  request.ground_height = region.Center().z();
  request.grade = region.grade;
  request.num_observations = region.num_observations;
  request.min_num_observations = min_num_observations;
  if (candidate.wind) request.wind_in_world = candidate.wind->wind_in_world;
  if (candidate.wind) request.wind_spread_mps = candidate.wind->spread_mps;
  return request;
}

}  // namespace freelsd
