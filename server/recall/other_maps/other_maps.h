// What maps of other flights say about a landing that is planned on one map. They add obstacles,
// never free ground:
// - Where the own map has seen nothing, the heights of the others stand as obstacles. The ground
//   there stays unseen.
// - A plan must hold on every map that shows its ground and is later, or may be. What a map merely
//   does not recognise as fit leaves the plan unverified.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "server/recall/altitude_datum.h"
#include "server/recall/kept_terrain.h"
#include "server/recall/map_cache.h"
#include "server/recall/other_maps/positive_evidence.h"
#include "server/recall/plan_check.h"
#include "server/recall/recall_sites.h"

namespace freelsd {

// Those of other flights that may meet the box, ordered by id.
SharedRows<MapRow> MapsOfOthers(const Storage& storage,
                                const std::string& flight_id,
                                const BoundingBox& box);

// Heights of another map, and the datum of its altitudes.
struct OtherGround {
  std::shared_ptr<const KeptTerrain> terrain;
  AltitudeReference reference;
};
// The upper heights of cells that no photograph of the own map saw become those of the other map,
// which is widened by both maps' deviations of position. The two maps are levelled by the ground
// that both have seen. If that is too little, their altitudes are compared, with both deviations;
// if their datums cannot be compared, nothing is added. `own` is the reference of the map's
// altitudes, `sigma` the number of deviations.
cv::Mat1f WithGroundOfOthers(const ElevationMap& map,
                             const GeoPoint& origin,
                             const AltitudeReference& own,
                             const std::vector<OtherGround>& others,
                             double sigma);

// True if another flight took photographs for the map after the last one that shows the site. Its
// ground may have changed then, and the plan must hold on the map.
bool IsLater(const MapRow& map, const SiteRow& site);
// True also if the order of the two is not known. Neither then replaces the other, and the plan
// must hold on both.
bool MayBeLater(const MapRow& map, const SiteRow& site);
// True if the map is also later than all photographs of the site's own map: only then it confirms
// the site. A flight that was sent twice confirms nothing.
bool IsLaterThanMap(const StoredSites& stored, const MapRow& map, const SiteRow& site);
// Begins a sentence on what a map of the flight or site `name` shows.
std::string OnOtherMap(const std::string& name, bool is_later);
// True if CheckedAround checks plans on later maps. It then needs their profile.
bool HasLaterMaps(const KeptSite& site);

// Checks the plan on a map that is stored or staged. The plan fails only if the map positively
// shows what breaks it; otherwise a broken rule is a doubt. Nothing if the map cannot be read, or
// if its flight judges no others: an experiment, or an aircraft with looser limits than every
// profile.
std::optional<PlanCheck> CheckPlanOn(const StoredSites& stored,
                                     const StoredPlan& plan,
                                     const MapRow& map,
                                     const OwnGround& own);
// The ground under the plan on the site's map, which may be staged. Nothing if it has none.
std::optional<ShownGround> OwnGroundOf(const StoredSites& stored,
                                       const SiteRow& site,
                                       const StoredPlan& plan);

// The plan, rejected if its circle meets an obstacle beyond the edge of the site's map, or if it
// fails on a later map; unverified, with a detail, if a later map doubts it. It was made on the
// site's map for this aircraft and wind, with Explanation::kFull: its profile levels maps that do
// not show the touchdown.
Plan CheckedAround(Plan plan,
                   const StoredSites& stored,
                   const KeptSite& site,
                   const Aircraft& aircraft,
                   const std::optional<Eigen::Vector2d>& wind_in_world);

// Checks the judgement's plan as CheckedAround does: adds the rule `surroundings`, and rejects the
// place if it fails. Nothing changes if a rule of the own map fails already.
void CheckAround(const StoredSites& stored,
                 const KeptSite& site,
                 const Aircraft& aircraft,
                 const std::optional<Eigen::Vector2d>& wind_in_world,
                 PlaceJudgement& judgement);

}  // namespace freelsd
