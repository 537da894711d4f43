#include "tests/evaluation/flown/flown_recall.h"

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "api/api.h"
#include "tests/engine/glide/point_mass.h"

namespace freelsd {
namespace {

constexpr double kMaxAwayM = 350.0;
constexpr double kMinHeightM = 20.0;
constexpr double kMaxHeightM = 250.0;
constexpr double kMaxHeightErrorM = 5.0;
constexpr double kMaxHeightErrorRatio = 0.05;
// Places of one path that are written to a centimetre are the same.
constexpr double kSamePlaceM = 0.1;
constexpr BoundingBox kEverywhere{-180.0, -90.0, 180.0, 90.0};

std::vector<DescentPoint> PointsOf(const nlohmann::json& site, const LocalFrame& local_frame) {
  std::vector<DescentPoint> points;
  const nlohmann::json& coordinates = site.at("path").at("coordinates");
  for (size_t i = 0; i < coordinates.size(); ++i) {
    const nlohmann::json& place = coordinates[i];
    points.push_back({local_frame.WorldFromGeo({place[1], place[0], place[2]}),
                      site.at("times_s")[i].get<double>()});
  }
  return points;
}

// The first point over the start of the final, which is the last but one.
size_t ArrivalOf(const std::vector<DescentPoint>& points) {
  const Eigen::Vector2d start = points[points.size() - 2].position_in_world.head<2>();
  const auto arrival = std::find_if(points.begin(), points.end(), [&](const DescentPoint& point) {
    return (point.position_in_world.head<2>() - start).norm() < kSamePlaceM;
  });
  return static_cast<size_t>(arrival - points.begin());
}

}  // namespace

EmergencyRequest RandomRequest(const World& world, std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const auto between = [&](double least, double most) {
    return least + (most - least) * unit(random);
  };
  EmergencyRequest request;
  request.altitude_datum = "amsl";
  const Eigen::Vector2d place(between(-kMaxAwayM, kMaxAwayM), between(-kMaxAwayM, kMaxAwayM));
  const double height =
      world.SurfaceHeight(place.x(), place.y()) + between(kMinHeightM, kMaxHeightM);
  request.place = LocalFrame(world.origin).GeoFromWorld({place.x(), place.y(), height});
  if (unit(random) < 0.85) request.heading_deg = between(0.0, 360.0);
  const double kind = unit(random);
  if (kind < 0.5) {
    request.wind_in_world = world.wind_in_world;
  } else if (kind < 0.9) {
    request.wind_in_world = between(0.0, 7.0) * DirectionOf(between(0.0, 2.0 * kPi));
  }
  return request;
}

RecalledWorld::RecalledWorld(const StoredSites& stored, const Mosaic& mosaic)
    : stored_(stored), mosaic_(mosaic) {
  for (const auto& row : stored.storage.sites.ListMaps(kEverywhere)) {
    const auto terrain = stored.maps.TerrainOf(stored.storage, row->id);
    if (terrain) terrains_.push_back(terrain);
  }
}

RecalledWorld::Recalled RecalledWorld::Recall(const EmergencyRequest& request) const {
  Recalled recalled{{}, RecallSites(stored_, request)};
  for (const nlohmann::json& site : recalled.answer.at("sites")) {
    if (site.contains("path")) recalled.paths.push_back(Fly(request, site));
  }
  return recalled;
}

bool RecalledWorld::IsOnMap(const GeoPoint& place) const {
  return std::any_of(terrains_.begin(), terrains_.end(), [&](const auto& terrain) {
    const Eigen::Vector3d on_map = LocalFrame(terrain->origin).WorldFromGeo(place);
    return LeastHeightOver(terrain->grid, terrain->upper, on_map, on_map).has_value();
  });
}

FlownPath RecalledWorld::Fly(const EmergencyRequest& request, const nlohmann::json& site) const {
  const LocalFrame local_frame(mosaic_.origin());
  const std::vector<DescentPoint> points = PointsOf(site, local_frame);
  const size_t arrival = ArrivalOf(points);
  const size_t final_start = points.size() - 2;
  const Aircraft aircraft = ParseAircraft(site.at("aircraft"), "/aircraft");
  GlideStart start{points.front().position_in_world, std::nullopt, request.wind_in_world};
  const Eigen::Vector2d first_way =
      (points[1].position_in_world - points[0].position_in_world).head<2>();
  start.heading = request.heading_deg ? RadFromDeg(*request.heading_deg) : HeadingOf(first_way);
  FlownPath flown;
  flown.site_id = site.at("site_id");
  if (site.contains("terrain_margin_m")) flown.terrain_margin_m = site["terrain_margin_m"];
  flown.surplus_height_m = points[final_start].position_in_world.z() -
                           local_frame
                               .WorldFromGeo({site["approach"]["start"]["latitude_deg"],
                                              site["approach"]["start"]["longitude_deg"],
                                              site["approach"]["start"]["altitude_m"]})
                               .z();
  const double told = points[arrival].position_in_world.z();
  flown.max_height_error_m =
      kMaxHeightErrorM + kMaxHeightErrorRatio * (start.position_in_world.z() - told);
  PointMass simulated(points, arrival, start, aircraft);
  bool has_arrived = arrival == 0;
  while (simulated.Step()) {
    const Eigen::Vector3d& at = simulated.position_in_world();
    if (!has_arrived && simulated.segment() >= arrival) {
      has_arrived = true;
      flown.height_error_m = at.z() - told;
    }
    const Eigen::Vector2d to_touchdown = (points.back().position_in_world - at).head<2>();
    const bool is_on_final = simulated.segment() >= final_start;
    if (is_on_final && to_touchdown.norm() <= aircraft.touchdown_uncertainty_m) break;
    const GeoPoint place = local_frame.GeoFromWorld(at);
    const MosaicPlace truth = mosaic_.PlaceOf(place);
    const double height = truth.HeightAbove();
    const bool is_on_way = !has_arrived;
    if (is_on_way && (height < flown.least_height_m.value_or(30.0)) && IsOnMap(place)) {
      flown.least_height_m = height;
    }
    if (height > 0.0) continue;
    flown.obstacle = is_on_final      ? Obstacle::kOnFinal
                     : !is_on_way     ? Obstacle::kInCircle
                     : IsOnMap(place) ? Obstacle::kOnMap
                                      : Obstacle::kOffMap;
    flown.met_in_world = at;
    flown.cover = truth.world->CoverAt(truth.in_world.x(), truth.in_world.y());
    flown.is_wire = truth.world->IsWireAt(truth.in_world.x(), truth.in_world.y());
    break;
  }
  return flown;
}

}  // namespace freelsd
