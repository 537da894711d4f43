// The stored input for planning a site again on its map.
#pragma once

#include <string>

#include "api/api.h"
#include "api/stored/stored.h"

namespace freelsd {

// Content of SiteRow::replan_json: the flight's request, its origin, and the region's plan request.
struct Replan {
  FlightRequest flight;
  GeoPoint origin;
  PlanRequest request;
};
// Plans approaches for one region and one aircraft on a stored map, which must outlive it. Not
// movable, because the planner refers to the layers.
struct StoredMapPlanner {
  StoredMapPlanner(const Replan& replan, const Aircraft& aircraft, const SiteMap& site_map);
  StoredMapPlanner(const StoredMapPlanner&) = delete;
  StoredMapPlanner& operator=(const StoredMapPlanner&) = delete;

  // Hazards for that aircraft.
  const HazardLayers layers;
  const ApproachPlanner planner;
};
std::string ReplanJson(const Replan& replan);
// Throws if the text is not valid by the current rules.
Replan ParseReplan(const std::string& text);

}  // namespace freelsd
