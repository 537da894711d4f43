#include "server/jobs/out_of_date.h"

#include <algorithm>
#include <string>

namespace freelsd {
namespace {

bool Contains(const BoundingBox& outer, const BoundingBox& inner) {
  const auto east_of_outer_west = [&outer](double longitude_deg) {
    const double turn_deg = longitude_deg < outer.west_deg ? 360.0 : 0.0;
    return longitude_deg + turn_deg - outer.west_deg;
  };
  const double inner_east_deg = east_of_outer_west(inner.east_deg);
  return east_of_outer_west(inner.west_deg) <= inner_east_deg &&
         inner_east_deg <= east_of_outer_west(outer.east_deg) &&
         outer.south_deg <= inner.south_deg && outer.north_deg >= inner.north_deg;
}

bool IsIn(const BoundingBox& box, const SiteRow& site) {
  return Contains(box,
                  {site.longitude_deg, site.latitude_deg, site.longitude_deg, site.latitude_deg});
}

}  // namespace

std::vector<std::string> OutOfDateSites(const std::vector<SiteRow>& stored,
                                        const std::vector<SiteRow>& sites,
                                        const std::vector<FlightMapRow>& maps,
                                        EvaluationScope scope) {
  std::set<std::string> ids;
  std::set<int64_t> region_ids;
  for (const SiteRow& site : sites) {
    ids.insert(site.id);
    region_ids.insert(site.region_id);
  }
  std::vector<std::string> out_of_date;
  for (const SiteRow& site : stored) {
    const bool is_replaced =
        site.region_id != kNoRegion
            ? region_ids.contains(site.region_id)
            : std::any_of(maps.begin(), maps.end(), [&site](const FlightMapRow& map) {
                return IsIn(map.box, site);
              });
    const bool is_out_of_date = scope == EvaluationScope::kEveryGraded || is_replaced;
    if (is_out_of_date && !ids.contains(site.id)) out_of_date.push_back(site.id);
  }
  return out_of_date;
}

std::vector<std::string> OutOfDateMaps(const std::vector<FlightMapRow>& stored,
                                       const std::vector<FlightMapRow>& added,
                                       const std::set<std::string>& needed,
                                       EvaluationScope scope) {
  std::vector<std::string> out_of_date;
  for (const FlightMapRow& map : stored) {
    const bool is_replaced =
        scope == EvaluationScope::kEveryGraded ||
        std::any_of(added.begin(), added.end(), [&map](const FlightMapRow& newer) {
          return Contains(newer.box, map.box);
        });
    if (is_replaced && !needed.contains(map.id)) out_of_date.push_back(map.id);
  }
  return out_of_date;
}

}  // namespace freelsd
