// What is stored of a site so that it can be planned again on its map.
#pragma once

#include <string>

#include "api/api.h"
#include "api/export/export.h"

namespace freelsd {

// SiteRow::replan_json: the flight as requested, its origin, and the region's part of the plan.
struct Replan {
  FlightRequest flight;
  GeoPoint origin;
  PlanRequest request;
};
// Plans for this region and an aircraft on a map stored before, which must live as long. Stays
// where it is: the planner refers to the layers.
struct StoredMapPlanner {
  StoredMapPlanner(const Replan& replan, const Aircraft& aircraft, const SiteMap& site_map);
  StoredMapPlanner(const StoredMapPlanner&) = delete;
  StoredMapPlanner& operator=(const StoredMapPlanner&) = delete;

  // For that aircraft.
  const HazardLayers layers;
  const ApproachPlanner planner;
};
std::string ReplanJson(const Replan& replan);
Replan ParseReplan(const std::string& text);

}  // namespace freelsd
