#include "server/recall/reach/reach.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include <nlohmann/json.hpp>

#include "api/api.h"
#include "server/recall/geoid/geoid.h"
#include "server/recall/reach/reach_obstacles.h"
#include "server/recall/recall_candidates.h"
#include "server/recall/terrain_margin.h"

namespace freelsd {
namespace {

constexpr double kMeanEarthRadiusM = 6371000.0;
// Larger boxes around the aircraft have too many maps; so much smaller is the next one tried.
constexpr double kNextRadiusRatio = 0.7;
// About a centimetre.
constexpr double kPlacesPerDegree = 1e7;

// Stored maps near the aircraft, and the radius around it in which all of them are.
struct NearbyMaps {
  std::vector<PlacedPatch> patches;
  double radius_m = 0.0;
  bool is_cut_short = false;
  std::set<DatumBasis> datum_bases;
};

SharedRows<MapRow> MapsWithin(const StoredSites& stored, const GeoPoint& place, double radius_m) {
  SharedRows<MapRow> rows = stored.storage.sites.ListMaps(BoxAround(place, radius_m));
  std::set<std::string> ids;
  std::erase_if(rows, [&ids](const auto& row) { return !ids.insert(row->id).second; });
  return rows;
}

NearbyMaps MapsAround(const StoredSites& stored,
                      GroundPatches& patches,
                      const EmergencyRequest& request,
                      const ReachFrame& frame,
                      double radius_m) {
  NearbyMaps nearby;
  nearby.radius_m = radius_m;
  SharedRows<MapRow> rows = MapsWithin(stored, request.place, radius_m);
  while (rows.size() > kLimits.answer.max_num_reach_maps) {
    nearby.is_cut_short = true;
    nearby.radius_m *= kNextRadiusRatio;
    rows = MapsWithin(stored, request.place, nearby.radius_m);
  }
  for (const auto& row : rows) {
    stored.stop_if_unwanted();
    const auto terrain = stored.maps.TerrainOf(stored.storage, row->id);
    if (!terrain || !terrain->CountsFor(request.flight_id)) continue;
    auto patch = patches.PatchOf(*row, terrain, frame);
    if (!patch) continue;
    const DatumDifference datum =
        DatumDifferenceOf(ReferenceOf(request), ReferenceOf(*row, *terrain));
    nearby.datum_bases.insert(datum.basis);
    nearby.patches.push_back({std::move(patch), datum.subtracted_m});
  }
  return nearby;
}

// What the search begins with.
struct Task {
  const EmergencyRequest& request;
  Aircraft aircraft;
  ReachFrame frame;
  // In the frame.
  GlideStart start;
};

Task TaskOf(const EmergencyRequest& request, const Aircraft& aircraft) {
  Task task{request, aircraft, ReachFrame(request.place), {}};
  const Eigen::Vector2d place = task.frame.FromGeo(request.place);
  task.start = StartOf(request, {place.x(), place.y(), request.place.altitude_m});
  if (task.start.heading) *task.start.heading += task.frame.north();
  if (task.start.wind_in_world) {
    *task.start.wind_in_world = Eigen::Rotation2Dd(-task.frame.north()) * *task.start.wind_in_world;
  }
  return task;
}

// A way in the air is longer than on the ellipsoid below, so lengths of the frame are stretched.
double StretchAt(double altitude_m) { return 1.0 + std::max(0.0, altitude_m) / kMeanEarthRadiusM; }

Reach ReachOver(const Task& task, const NearbyGround& nearby, const ReachLimits& limits) {
  const double stretch = StretchAt(task.request.place.altitude_m);
  GlideStart start = task.start;
  start.position_in_world.head<2>() *= stretch;
  ReachGround ground = nearby.ground;
  ground.grid.north_west_in_world *= stretch;
  ground.grid.cell_size_m *= stretch;
  Reach reach = ReachOf(start, ground, task.aircraft, GlideOptions{}, limits);
  for (auto* const areas : {&reach.known, &reach.unknown}) {
    for (ReachArea& area : *areas) {
      for (Eigen::Vector2d& corner : area.outer) corner /= stretch;
      for (Polygon& hole : area.holes) {
        for (Eigen::Vector2d& corner : hole) corner /= stretch;
      }
    }
  }
  return reach;
}

nlohmann::json RingJson(const Polygon& ring, const ReachFrame& frame) {
  const auto rounded = [](double angle_deg) {
    return std::round(angle_deg * kPlacesPerDegree) / kPlacesPerDegree;
  };
  nlohmann::json positions = nlohmann::json::array();
  for (const Eigen::Vector2d& corner : ring) {
    const GeoPoint place = frame.ToGeo(corner);
    positions.push_back({rounded(place.longitude_deg), rounded(place.latitude_deg)});
  }
  positions.push_back(positions.front());
  return positions;
}

// The coordinates of a polygon.
nlohmann::json RingsJson(const ReachArea& area, const ReachFrame& frame) {
  nlohmann::json rings{RingJson(area.outer, frame)};
  for (const Polygon& hole : area.holes) rings.push_back(RingJson(hole, frame));
  return rings;
}

double AreaM2(const ReachArea& area) {
  double area_m2 = Area(area.outer);
  for (const Polygon& hole : area.holes) area_m2 -= Area(hole);
  return std::round(area_m2);
}

nlohmann::json FeatureOf(nlohmann::json geometry, nlohmann::json properties) {
  return {{"type", "Feature"},
          {"geometry", std::move(geometry)},
          {"properties", std::move(properties)}};
}

void AddReach(const Reach& reach, const ReachFrame& frame, nlohmann::json& features) {
  for (const ReachArea& area : reach.known) {
    features.push_back(FeatureOf({{"type", "Polygon"}, {"coordinates", RingsJson(area, frame)}},
                                 {{"kind", "reach"}, {"area_m2", AreaM2(area)}}));
  }
}

void AddUnknown(const Reach& reach,
                const ReachFrame& frame,
                double assumed_altitude_m,
                nlohmann::json& features) {
  if (reach.unknown.empty()) return;
  double area_m2 = 0.0;
  nlohmann::json polygons = nlohmann::json::array();
  for (const ReachArea& area : reach.unknown) {
    polygons.push_back(RingsJson(area, frame));
    area_m2 += AreaM2(area);
  }
  const bool is_one = polygons.size() == 1;
  nlohmann::json geometry{{"type", is_one ? "Polygon" : "MultiPolygon"}};
  geometry["coordinates"] = is_one ? polygons.front() : std::move(polygons);
  features.push_back(FeatureOf(std::move(geometry),
                               {{"kind", "unknown_terrain"},
                                {"area_m2", area_m2},
                                {"assumed_ground_altitude_m", assumed_altitude_m}}));
}

// `site` is one of RecallSites' answer.
nlohmann::json SiteFeature(const nlohmann::json& site) {
  const nlohmann::json& touchdown = site.at("touchdown");
  nlohmann::json properties{{"kind", "site"}};
  for (const char* const key : {"site_id",
                                "flight_id",
                                "rank",
                                "reachable",
                                "verdict",
                                "arrival_margin_m",
                                "terrain_margin_m",
                                "missing_m",
                                "surplus_height_m",
                                "reason",
                                "sentence",
                                "distance_m",
                                "bearing_deg",
                                "time_s",
                                "score",
                                "age_s"}) {
    if (site.contains(key)) properties[key] = site[key];
  }
  return FeatureOf(
      {{"type", "Point"},
       {"coordinates",
        {touchdown.at("longitude_deg"), touchdown.at("latitude_deg"), touchdown.at("altitude_m")}}},
      std::move(properties));
}

double LowestOf(const std::vector<PlacedPatch>& patches) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const PlacedPatch& placed : patches) {
    lowest = std::min(lowest, placed.patch->lowest + placed.added_m);
  }
  return lowest;
}

// Adds the areas, and what they were computed from. Returns Reach::cells_per_side.
int AddAreas(const StoredSites& stored,
             const Task& task,
             const NearbyMaps& maps,
             nlohmann::json& answer) {
  const EmergencyRequest& request = task.request;
  answer["assumed_ground_altitude_m"] = nullptr;
  answer["cell_size_m"] = nullptr;
  answer["num_maps"] = 0;
  answer["wires_known"] = AreWiresKnown(stored, {request.place});
  if (maps.patches.empty()) return 1;
  const double height_m = request.place.altitude_m - LowestOf(maps.patches);
  const double farthest_m =
      GreatestGlideDistance(task.start, height_m, task.aircraft, GlideOptions{});
  const double radius_m = std::min(maps.radius_m, farthest_m);
  NearbyGround nearby =
      GroundAround(task.start.position_in_world.head<2>(), radius_m, maps.patches);
  if (nearby.num_maps == 0) return 1;
  AddObstacles(stored.maps.ObstaclesNear(stored.storage, BoxAround(request.place, radius_m)),
               request,
               task.frame,
               task.aircraft.path_half_width_m,
               nearby);
  const ReachLimits limits{request.terrain_clearance_m,
                           request.arrival_height_m,
                           static_cast<int>(kLimits.answer.max_num_reach_vertices),
                           kLimits.answer.max_reach_work,
                           stored.stop_if_unwanted};
  const Reach reach = ReachOver(task, nearby, limits);
  answer["assumed_ground_altitude_m"] = nearby.assumed_altitude_m;
  answer["cell_size_m"] = nearby.ground.grid.cell_size_m * reach.cells_per_side;
  answer["num_maps"] = nearby.num_maps;
  AddReach(reach, task.frame, answer["features"]);
  AddUnknown(reach, task.frame, nearby.assumed_altitude_m, answer["features"]);
  return reach.cells_per_side;
}

}  // namespace

nlohmann::json ReachFrom(const StoredSites& stored,
                         GroundPatches& patches,
                         const EmergencyRequest& request) {
  const RecallBounds bounds = stored.storage.sites.BoundsOfRecallable();
  const Task task = TaskOf(request, LeastGlidingAircraft(request, bounds));
  // Down to the lowest site, or to the sea where there are none.
  const double height_m = request.place.altitude_m + kMaxGeoidHeightM - bounds.min_altitude_m;
  const double radius_m = std::min(
      kMaxReachM, GreatestGlideDistance(task.start, height_m, task.aircraft, GlideOptions{}));
  const NearbyMaps maps = MapsAround(stored, patches, request, task.frame, radius_m);
  nlohmann::json answer{{"type", "FeatureCollection"},
                        {"features", nlohmann::json::array()},
                        {"altitude_datum", request.altitude_datum.value_or("unknown")},
                        {"terrain_clearance_m", request.terrain_clearance_m},
                        {"arrival_height_m", request.arrival_height_m},
                        {"aircraft", AircraftJson(task.aircraft)}};
  const int cells_per_side = AddAreas(stored, task, maps, answer);
  nlohmann::json recalled = RecallSites(stored, request);
  for (const nlohmann::json& site : recalled["sites"]) {
    answer["features"].push_back(SiteFeature(site));
  }
  if (recalled.contains("nearest_miss")) {
    answer["features"].push_back(SiteFeature(recalled["nearest_miss"]));
  }
  answer["warnings"] = std::move(recalled["warnings"]);
  if (answer["num_maps"] == 0)
    answer["warnings"].push_back("no stored map is within gliding distance");
  if (cells_per_side > 1) {
    answer["warnings"].push_back(
        "so many winds and headings over so wide an area are computed on larger cells "
        "(cell_size_m): more ground may be in reach than is shown; a given wind and heading make "
        "the areas finer");
  }
  if (maps.is_cut_short) {
    answer["warnings"].push_back("there are too many stored maps: farther ones are left out");
  }
  return answer;
}

}  // namespace freelsd
