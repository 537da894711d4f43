// The site that a path names, and what of it is needed to plan on its map again.
#pragma once

#include <string>

#include "api/api.h"
#include "api/export/export.h"
#include "server/call.h"
#include "server/service.h"

namespace freelsd {

// Throws ApiError NoSuchSite.
SiteRow ExistingSite(const Service& service, const Call& call);

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
