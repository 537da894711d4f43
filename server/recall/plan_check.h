// Checks the stored plan of a site on the map of another flight. Private to recall.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "api/api.h"
#include "api/stored/stored.h"
#include "engine/obstacles/obstacles.h"
#include "server/recall/replan.h"
#include "storage/storage.h"

namespace freelsd {

// The plan that was stored with an accepted site, and the aircraft and wind for which it was made.
struct StoredPlan {
  Replan replan;
  // Always has final_places.
  StoredSite site;
};
// Nothing if the site was rejected, or if its row is invalid by current rules.
std::optional<StoredPlan> ReadStoredPlan(const SiteRow& row);
// A plan that is not stored, made with the request's aircraft and wind in the world of its origin.
// The plan has an approach.
StoredPlan AsStoredPlan(const Plan& plan, Replan replan);
// The ground that CheckPlan reads on a map with this grid and deviation of its position, in the
// map's world.
Polygon CheckedGroundOf(const StoredPlan& plan,
                        const GeoPoint& map_origin,
                        const Grid& grid,
                        double position_sd_m);
// Box around the ground that CheckPlan reads.
BoundingBox BoxOf(const StoredPlan& plan);

enum class PlanVerdict {
  kHolds,   // disc, ground roll and final are wholly seen, and no rule is broken
  kFails,   // something seen breaks a rule
  kDoubts,  // a rule is broken, but by nothing that the map positively shows (CheckPlanOn)
  kUnknown  // none of them
};
struct PlanCheck {
  PlanVerdict verdict = PlanVerdict::kUnknown;
  // Set if verdict is kFails or kDoubts: the broken rule, and a sentence with numbers.
  std::optional<RejectReason> reason;
  std::string detail;
};
// Checks the plan on the map of another flight, with the plan's own aircraft, wind and options.
// Those of the other flight do not matter, because only a change of the ground counts.
PlanCheck CheckPlan(const StoredPlan& plan, const GeoPoint& map_origin, const SiteMap& site_map);
// What changes of the own map's ground break of the plan: nothing if it holds with them, or if the
// unchanged map breaks the same rule. Both maps are on one grid. What is unsure is no change.
std::optional<PlanCheck> BrokenByChanges(const StoredPlan& plan,
                                         const SiteMap& own_map,
                                         const SiteMap& changed_map);
// How far from their touchdowns the plans of stored sites need ground, at least 2.2 km. It holds
// for the stored aircraft in any wind in which they make headway. It may not hold for a flight
// whose options allow start heights above the usual ones.
double ReachOfPlans(const RecallBounds& bounds);
// What obstacles break of the plan, on its own map; nothing if it holds with them. What is unsure
// counts against the plan.
std::optional<PlanCheck> BrokenByObstacles(const StoredPlan& plan,
                                           const SiteMap& own_map,
                                           const std::vector<HardObstacle>& obstacles);

}  // namespace freelsd
