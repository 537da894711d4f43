// Which legs to fly next over a flight's map. Computed when asked, from what is stored: while a
// flight streams in, the answer follows its newest map.
#include <algorithm>
#include <cmath>
#include <iterator>

#include <nlohmann/json.hpp>

#include "api/api.h"
#include "api/export/legs/legs.h"
#include "server/handlers/flight_picture.h"
#include "server/handlers/handlers.h"
#include "server/handlers/lookups.h"
#include "server/handlers/paging.h"
#include "server/recall/recall.h"

namespace freelsd {
namespace {

constexpr int kMaxLegs = 8;
// A larger map is read at a coarser level.
constexpr double kMaxCells = 4e6;

NextLookOptions LookOptionsOf(const Call& call) {
  NextLookOptions options;
  const int64_t num_legs = call.QueryInteger("legs").value_or(options.num_legs);
  if (num_legs < 1 || num_legs > kMaxLegs) {
    const std::string detail = "must be a whole number, 1 to " + std::to_string(kMaxLegs);
    throw ApiError("InvalidValue", "legs: " + detail, {{"legs", detail}});
  }
  options.num_legs = static_cast<int>(num_legs);
  return options;
}

std::string LookFormatOf(const Call& call) {
  std::string format = call.Query("f").value_or("geojson");
  if (format == "geojson" || format == "plan") return format;
  const std::string detail = "f: must be geojson or plan";
  throw ApiError("InvalidQuery", detail, {{"f", detail}});
}

// With the obstacles that are in force, for the aircraft of the flight.
MapRasters LookedGround(const Service& service, const FlightMap& map) {
  int level = 0;
  Grid grid = map.GridAt(level);
  while (level + 1 < map.head.num_levels &&
         static_cast<double>(grid.num_rows) * grid.num_cols > kMaxCells) {
    grid = map.GridAt(++level);
  }
  MapRasters rasters =
      service.maps.flight_maps().Read(service.storage, map, level, grid, TileLayers::kAll);
  const AltitudeReference reference{map.row.altitude_datum,
                                    map.head.origin.latitude_deg,
                                    map.head.origin.longitude_deg,
                                    map.row.flight_id};
  const auto obstacles =
      InWorld(service.maps.ObstaclesNear(service.storage, map.row.box), map.local_frame, reference);
  SiteMap& ground = rasters.site_map;
  AssessedMap with_obstacles = WithObstacles(ground.map, ground.layers, obstacles, {});
  ground.map = std::move(with_obstacles.map);
  ground.layers = WithLimits(ground.map,
                             with_obstacles.layers,
                             {map.aircraft.max_slope_deg, map.aircraft.max_roughness_m},
                             map.hazard_options);
  return rasters;
}

Verdict VerdictOf(const StoredSite& site) {
  if (site.IsRejected()) return Verdict::kRejected;
  return site.verdict == "landable" ? Verdict::kLandable : Verdict::kUnverified;
}

SiteSoFar SiteSoFarOf(const StoredSite& site, const LocalFrame& local_frame) {
  SiteSoFar so_far;
  so_far.verdict = VerdictOf(site);
  so_far.touchdown_in_world = local_frame.WorldFromGeo(site.touchdown);
  if (!site.final_places) return so_far;
  const FinalPlaces& places = *site.final_places;
  PlannedLanding landing;
  landing.touchdown_in_world = so_far.touchdown_in_world;
  landing.heading = RadFromDeg(places.heading_deg);
  landing.approach_distance = places.distance_m;
  landing.approach_height = places.height_m;
  landing.loiter_center_in_world = local_frame.WorldFromGeo(places.loiter_center).head<2>();
  landing.loiter_radius = places.loiter_radius_m;
  so_far.landing = landing;
  return so_far;
}

// The sites of a flight, as the engine and as the client knows them.
struct KnownSites {
  std::vector<SiteSoFar> so_far;
  std::vector<LookSiteName> names;
};

KnownSites KnownSitesOf(const Service& service,
                        const std::string& flight_id,
                        const LocalFrame& local_frame) {
  KnownSites sites;
  for (const SiteRow& row : SitesOfFlight(service, flight_id)) {
    if (row.superseded_by) continue;
    const StoredSite site = SiteOf(row);
    sites.so_far.push_back(SiteSoFarOf(site, local_frame));
    sites.names.push_back({site.id, site.verdict});
  }
  return sites;
}

// How the camera is mounted; as by default if the flight is deleted.
Rigid3d MountingOf(const Service& service, const std::string& flight_id) {
  const auto flight = service.storage.flights.Find(flight_id);
  if (!flight || flight->rig_json.empty()) return Rig().body_from_camera;
  return ParseStoredFlightRig(flight->rig_json).rig.body_from_camera;
}

NextLook LookOn(const Service& service,
                const FlightMap& map,
                const std::vector<SiteSoFar>& sites,
                const NextLookOptions& options,
                const StopIfUnwanted& stop_if_unwanted) {
  const MapRasters ground = LookedGround(service, map);
  // All tiles may be damaged.
  if (cv::countNonZero(ground.site_map.layers.hazard != kUnseen) == 0) return {};
  const Rig rig{map.head.camera, MountingOf(service, map.row.flight_id)};
  std::vector<Rigid3d> flown;
  for (const MapView& view : map.head.views) flown.push_back(view.world_from_camera);
  LookRequest request{.map = ground.site_map.map,
                      .layers = ground.site_map.layers,
                      .num_views = ground.coverage,
                      .sites = sites,
                      .rig = rig,
                      .flown = flown,
                      .aircraft = map.aircraft,
                      .before_leg = stop_if_unwanted};
  if (map.head.wind) request.wind_in_world = map.head.wind->wind_in_world;
  return ChooseNextLook(request, options);
}

std::vector<std::shared_ptr<const FlightMap>> MapsToLookAt(const Service& service,
                                                           const std::string& flight_id) {
  auto maps = ReadableMaps(service, flight_id);
  std::erase_if(maps, [](const auto& map) { return map->head.views.empty(); });
  if (!maps.empty()) return maps;
  if (!service.storage.flights.Find(flight_id)) {
    throw ApiError("NoSuchFlight", "there is no such flight");
  }
  throw ApiError("NoMapYet",
                 "the flight has no map yet: legs can be chosen once its first evaluation is done");
}

}  // namespace

void GetNextLook(Service& service, const Call& call, httplib::Response& response) {
  const NextLookOptions options = LookOptionsOf(call);
  const std::string format = LookFormatOf(call);
  const ExportOptions export_options = ExportOptionsOf(call);
  const auto maps = MapsToLookAt(service, call.Id("flight"));
  const FlightMap& newest = *maps.front();
  const FlightContext context{newest.row.flight_id, newest.row.altitude_datum, newest.local_frame};
  // Before the legs are chosen, which takes seconds.
  if (format == "plan") RequireAltitudes(context, export_options);
  const KnownSites sites = KnownSitesOf(service, call.Id("flight"), maps.front()->local_frame);
  const StopIfUnwanted stop_if_unwanted = WantedBy(service, call);
  const LongPlace place(service.long_queues.routes, stop_if_unwanted);
  // A long flight has several maps. The legs lie on the one where they promise most.
  std::optional<NextLook> best;
  for (const auto& map : maps) {
    NextLook look = LookOn(service, *map, sites.so_far, options, stop_if_unwanted);
    if (!best || look.expected_gain > best->expected_gain) best = std::move(look);
  }
  if (format == "plan") {
    const std::string plan = LegsPlan(*best, context, export_options);
    response.set_header("Content-Disposition",
                        "attachment; filename=\"" + context.flight_id + "-next-look.plan\"");
    return response.set_content(plan, "application/vnd.qgroundcontrol.plan+json");
  }
  AnswerGeoJson(LegsJson(*best, sites.names, context), response);
}

}  // namespace freelsd
