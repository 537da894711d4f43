#include "server/recall/map_place/map_place.h"

#include <cmath>
#include <numbers>
#include <utility>

namespace freelsd {
namespace {

Polygon DiscAround(const Eigen::Vector2d& place, double radius) {
  constexpr int kNumCorners = 24;
  Polygon disc;
  for (int i = 0; i < kNumCorners; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / kNumCorners;
    disc.push_back(place + radius * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
  }
  return disc;
}

Eigen::Vector2d InWorld(const FlightMap& map, const GeoPoint& place) {
  return map.local_frame
      .WorldFromGeo({place.latitude_deg, place.longitude_deg, map.head.origin.altitude_m})
      .head<2>();
}

bool IsSeenAt(const StoredSites& stored, const FlightMap& map, const cv::Point& cell) {
  const Grid one = map.head.grid.Part({cell.x, cell.y, 1, 1});
  const MapRasters rasters =
      stored.maps.flight_maps().Read(stored.storage, map, 0, one, TileLayers::kPlanning);
  return !std::isnan(rasters.site_map.map.elevation(0, 0));
}

// Free ground for the aircraft, in cells of the disc.
double FreeArea(const KeptSite& site, const Aircraft& aircraft) {
  const HazardLayers layers = WithLimits(site.obstructed_map.map,
                                         site.obstructed_map.layers,
                                         {aircraft.max_slope_deg, aircraft.max_roughness_m},
                                         site.replan.flight.options.hazard);
  const Grid& grid = layers.grid;
  double num_free = 0.0;
  for (const cv::Point& cell : grid.CellsIn(site.replan.request.footprint)) {
    num_free += layers.hazard(cell) == kFree ? 1.0 : 0.0;
  }
  return num_free * grid.cell_size_m * grid.cell_size_m;
}

}  // namespace

std::shared_ptr<const FlightMap> MapAt(const StoredSites& stored,
                                       const std::string& flight_id,
                                       const GeoPoint& place) {
  std::shared_ptr<const FlightMap> newest;
  for (const FlightMapRow& row : stored.storage.maps.ListOf(flight_id)) {
    auto map = stored.maps.flight_maps().Find(stored.storage, row.id);
    if (!map) continue;
    const auto cell = map->head.grid.CellAt(InWorld(*map, place));
    if (!cell) continue;
    if (IsSeenAt(stored, *map, *cell)) return map;
    if (!newest) newest = std::move(map);
  }
  return newest;
}

std::shared_ptr<const KeptSite> SiteAt(const StoredSites& stored,
                                       const FlightMap& map,
                                       const GeoPoint& place,
                                       const std::optional<Aircraft>& aircraft,
                                       const std::optional<Eigen::Vector2d>& wind_in_world) {
  KeptSite site;
  site.row.flight_id = map.row.flight_id;
  site.row.map_id = map.row.id;
  site.row.seen_at_us = map.row.seen_at_us;
  site.row.seen_until_us = map.row.seen_until_us;
  site.replan.flight = ParseStoredFlightRequest(map.head.flight_json);
  site.replan.origin = map.head.origin;
  const FlightRequest& flight = site.replan.flight;
  const Aircraft used = aircraft.value_or(flight.aircraft);
  const Eigen::Vector2d place_in_world = InWorld(map, place);
  PlanRequest& request = site.replan.request;
  request.footprint = DiscAround(place_in_world, kLandingRadiusM);
  request.grade = 1.0;
  request.min_num_observations = flight.options.regions.min_num_observations_floor;
  request.wind_in_world = wind_in_world;
  if (map.head.wind && wind_in_world == map.head.wind->wind_in_world) {
    request.wind_spread_mps = map.head.wind->spread_mps;
  }
  const double least = flight.options.backend.max_surroundings_m;
  site.reach =
      PlanReach(used, wind_in_world, request.wind_spread_mps, least, flight.options.approach);
  const Grid& whole = map.head.grid;
  const Grid around = whole.Part(whole.CellsAround(request.footprint, site.reach));
  MapRasters rasters =
      stored.maps.flight_maps().Read(stored.storage, map, 0, around, TileLayers::kAll);
  if (const auto cell = around.CellAt(place_in_world)) {
    request.num_observations = rasters.coverage(*cell);
  }
  site.site_map = std::move(rasters.site_map);
  auto kept =
      std::make_shared<KeptSite>(stored.maps.InSurroundings(stored.storage, std::move(site)));
  kept->replan.request.area_m2 = FreeArea(*kept, used);
  return kept;
}

}  // namespace freelsd
