#include <set>
#include <utility>

#include <nlohmann/json.hpp>

#include "server/recall/obstacles/obstacles.h"
#include "server/recall/other_maps/other_maps.h"
#include "server/recall/plan_check.h"
#include "server/recall/recall_sites.h"

namespace freelsd {
namespace {

// Plans reach less far from their touchdown.
constexpr double kPlanReachM = 2500.0;

std::vector<std::string> IdsOf(const std::vector<HardObstacle>& obstacles) {
  std::set<std::string> ids;
  for (const HardObstacle& obstacle : obstacles) ids.insert(obstacle.id);
  return {ids.begin(), ids.end()};
}

// Those that break the plan each alone; all where only several together do.
std::vector<std::string> BlockingIds(const StoredPlan& plan,
                                     const SiteMap& own_map,
                                     const std::vector<HardObstacle>& obstacles) {
  std::vector<HardObstacle> blocking;
  for (const HardObstacle& obstacle : obstacles) {
    if (BrokenByObstacles(plan, own_map, {obstacle})) blocking.push_back(obstacle);
  }
  return IdsOf(blocking.empty() ? obstacles : blocking);
}

std::optional<Obstruction> Computed(const StoredSites& stored, const SiteRow& site) {
  const std::optional<StoredPlan> plan = ReadStoredPlan(site);
  if (!plan) return std::nullopt;
  const auto kept = stored.maps.Get(stored.storage, site.id, site.updated_at_us);
  // Whether the obstacles nearby break the plan is then unknown, and unknown is not safe.
  if (!kept) return Obstruction{"no_terrain", "the site's map cannot be read", {}};
  const std::optional<PlanCheck> check = BrokenByObstacles(*plan, kept->site_map, kept->obstacles);
  if (!check) return std::nullopt;
  return Obstruction{
      NameOf(*check->reason), check->detail, BlockingIds(*plan, kept->site_map, kept->obstacles)};
}

SiteRow AsRejected(SiteRow site, const Obstruction& obstruction, const std::string& by) {
  nlohmann::json feature = nlohmann::json::parse(site.feature_json);
  nlohmann::json& properties = feature["properties"];
  properties["verdict"] = "rejected";
  properties["reject_reason"] = obstruction.reason;
  properties["reject_detail"] = obstruction.detail;
  if (!obstruction.obstacle_ids.empty()) properties["blocked_by"] = obstruction.obstacle_ids;
  properties["summary"] = "Rejected: " + by + obstruction.detail + ".";
  properties["why"] = "Ranked last: " + by + obstruction.detail + ".";
  // They were those of the ground without what rejects it.
  properties["score"] = 0.0;
  for (const char* const name : {"failure_probability", "failure_parts", "hazard_distance_m"}) {
    properties[name] = nullptr;
  }
  site.feature_json = feature.dump();
  return site;
}

// Nothing replaces the site, but the other map rejects it.
SiteRow AsContested(SiteRow site) {
  const Standing standing = std::exchange(static_cast<Standing&>(site), Standing{});
  site.confirmed_at_us = standing.confirmed_at_us;
  return AsRejected(std::move(site),
                    {standing.superseded_reason,
                     OnOtherMap(*standing.superseded_by, false) + standing.superseded_detail,
                     {}},
                    "");
}

}  // namespace

std::optional<Obstruction> ObstructionOf(const StoredSites& stored, const SiteRow& site) {
  if (site.approach_json.empty()) return std::nullopt;
  const GeoPoint touchdown{site.latitude_deg, site.longitude_deg, 0.0};
  const std::string key =
      KeyOf(stored.maps.ObstaclesNear(stored.storage, BoxAroundPlace(touchdown, kPlanReachM)));
  if (key.empty()) return std::nullopt;
  if (auto known = stored.maps.KeptObstruction(site, key)) return *known;
  std::optional<Obstruction> obstruction = Computed(stored, site);
  stored.maps.KeepObstruction(site, key, obstruction);
  return obstruction;
}

SiteRow AsObstructed(const StoredSites& stored, SiteRow site) {
  if (site.IsContested()) return AsContested(std::move(site));
  const std::optional<Obstruction> obstruction = ObstructionOf(stored, site);
  if (!obstruction) return site;
  std::string ids;
  for (const std::string& id : obstruction->obstacle_ids) ids += (ids.empty() ? "" : ", ") + id;
  return AsRejected(std::move(site), *obstruction, ids.empty() ? "" : "blocked by " + ids + ": ");
}

}  // namespace freelsd
