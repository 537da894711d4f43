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

// The way down that was stored with an accepted site, its aircraft and its wind.
struct StoredPlan {
  Replan replan;
  // With final_places.
  StoredSite site;
};
// Nothing if the site was rejected, or if its row is invalid by current rules.
std::optional<StoredPlan> ReadStoredPlan(const SiteRow& row);
// A box around everything of the plan that a check reads.
BoundingBox BoxOf(const StoredPlan& plan);

enum class PlanVerdict {
  kHolds,   // disc, ground roll and final are wholly seen, and no rule is broken
  kFails,   // something seen breaks a rule
  kUnknown  // neither
};
struct PlanCheck {
  PlanVerdict verdict = PlanVerdict::kUnknown;
  // If it fails: the broken rule, as reject_reason, and a sentence with numbers.
  std::string reason;
  std::string detail;
};
// The check uses the plan's own aircraft, wind and options: what another flight asks for does not
// change the ground.
PlanCheck CheckPlan(const StoredPlan& plan, const GeoPoint& map_origin, const SiteMap& site_map);
// What obstacles break of the plan, on its own map; nothing if it holds with them. What is unsure
// counts against the plan.
std::optional<PlanCheck> BrokenByObstacles(const StoredPlan& plan,
                                           const SiteMap& own_map,
                                           const std::vector<HardObstacle>& obstacles);

}  // namespace freelsd
