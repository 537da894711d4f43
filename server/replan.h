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
// The plan for this request and the flight's aircraft, on a map stored before.
Plan PlanOnStoredMap(const Replan& replan, const SiteMap& site_map);
std::string ReplanJson(const Replan& replan);
Replan ParseReplan(const std::string& text);

}  // namespace freelsd
