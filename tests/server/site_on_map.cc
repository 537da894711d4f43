#include "tests/server/site_on_map.h"

#include <cmath>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "server/jobs/staged_maps.h"
#include "server/maps/maps.h"
#include "server/recall/replan.h"

namespace freelsd {
namespace {

bool Overlap(const BoundingBox& a, const BoundingBox& b) {
  const double apart_deg = std::remainder(a.west_deg - b.west_deg, 360.0);
  const auto width = [](const BoundingBox& box) {
    return box.east_deg - box.west_deg + (box.east_deg < box.west_deg ? 360.0 : 0.0);
  };
  return a.south_deg <= b.north_deg && b.south_deg <= a.north_deg && apart_deg <= width(b) &&
         -apart_deg <= width(a);
}

std::vector<std::string> FormerMaps(const Storage& storage,
                                    const SiteRow& site,
                                    const std::optional<BoundingBox>& box) {
  std::set<std::string> needed;
  std::string own;
  for (const SiteRow& stored : storage.sites.List(site.flight_id, std::nullopt)) {
    if (stored.id != site.id) needed.insert(stored.map_id);
    if (stored.id == site.id) own = stored.map_id;
  }
  std::vector<std::string> former;
  for (const FlightMapRow& map : storage.maps.ListOf(site.flight_id)) {
    const bool is_former = map.id == own || (box && Overlap(map.box, *box));
    if (is_former && !needed.contains(map.id)) former.push_back(map.id);
  }
  return former;
}

}  // namespace

FlightMapRow StageMapOf(Storage& storage, const SiteRow& site, const SiteMap& ground) {
  const Replan replan = ParseReplan(site.replan_json);
  MapHead head;
  head.flight_json = replan.flight.canonical_json;
  head.origin = replan.origin;
  head.grid = ground.map.grid;
  head.position_sd_m = ground.map.position_sd_m;
  head.tilt_sd_deg = ground.map.tilt_sd_deg;
  head.is_compared = ground.map.is_compared;
  head.camera.width_px = 320;
  head.camera.height_px = 640;
  head.camera.fx_px = head.camera.fy_px = 100.0;
  FlightMapRow map;
  map.id = storage.maps.NewId(site.flight_id);
  map.flight_id = site.flight_id;
  map.altitude_datum = replan.flight.altitude_datum.value_or("unknown");
  map.box = BoxOf(head.grid, LocalFrame(head.origin));
  map.updated_at_us = site.updated_at_us;
  map.seen_at_us = site.seen_at_us;
  map.seen_until_us = site.seen_until_us;
  StageMap(storage, map, head, {ground, cv::Mat1b(ground.map.elevation.size(), uchar{2})});
  return map;
}

EvaluationRows RowsOnMap(Storage& storage, SiteRow site, const SiteMap& ground) {
  const FlightMapRow map = StageMapOf(storage, site, ground);
  site.map_id = map.id;
  return {{site}, {}, {map.id}, FormerMaps(storage, site, map.box)};
}

void PutOnMap(Storage& storage,
              const SiteRow& site,
              const SiteMap& ground,
              const Standings& others) {
  storage.sites.PutEvaluation(RowsOnMap(storage, site, ground), others);
}

void PutWithoutMap(Storage& storage, const SiteRow& site) {
  storage.sites.PutEvaluation({{site}, {}, {}, FormerMaps(storage, site, std::nullopt)}, {});
}

}  // namespace freelsd
