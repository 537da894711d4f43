#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/footprint/footprint.h"
#include "engine/obstacles/obstacles.h"
#include "server/recall/emergency_request.h"
#include "server/recall/obstacles/obstacles.h"
#include "server/recall/terrain_margin.h"

namespace freelsd {
namespace {

constexpr double kStepM = 5.0;
constexpr double kAirspaceStepM = 25.0;

// A plane around one point, metres east and north; exact enough within some kilometres.
class Plane {
 public:
  explicit Plane(const GeoPoint& middle)
      : middle_(middle), shrink_(std::cos(RadFromDeg(middle.latitude_deg))) {}
  Eigen::Vector2d At(const GeoPoint& place) const {
    const double dlon_deg = std::remainder(place.longitude_deg - middle_.longitude_deg, 360.0);
    return kMetresPerDegree *
           Eigen::Vector2d(dlon_deg * shrink_, place.latitude_deg - middle_.latitude_deg);
  }

 private:
  GeoPoint middle_;
  double shrink_;
};

GeoPoint Between(const GeoPoint& a, const GeoPoint& b, double ratio) {
  const double dlon_deg = std::remainder(b.longitude_deg - a.longitude_deg, 360.0);
  return {a.latitude_deg + ratio * (b.latitude_deg - a.latitude_deg),
          a.longitude_deg + ratio * dlon_deg,
          a.altitude_m + ratio * (b.altitude_m - a.altitude_m)};
}

BoundingBox BoxOf(const std::vector<GeoPoint>& path) {
  BoundingBox box = BoxAroundPlace(path.front(), 0.0);
  for (const GeoPoint& point : path) {
    const double longitude_deg =
        box.west_deg + std::remainder(point.longitude_deg - box.west_deg, 360.0);
    box = {std::min(box.west_deg, longitude_deg),
           std::min(box.south_deg, point.latitude_deg),
           std::max(box.east_deg, longitude_deg),
           std::max(box.north_deg, point.latitude_deg)};
  }
  return box;
}

// Calls `visit` along the path. It returns how far the path surely meets nothing new, metres; the
// next call is at most that far away, and at least a step.
template <typename Visit>
void March(const std::vector<GeoPoint>& path, double step_m, const Visit& visit) {
  // Distances in a plane are exact to a few percent over hundreds of kilometres.
  constexpr double kShareOfFree = 0.8;
  double skipped_m = 0.0;
  for (size_t i = 0; i < path.size(); ++i) {
    const GeoPoint& begin = path[i > 0 ? i - 1 : 0];
    const double length_m = Plane(begin).At(path[i]).norm();
    double along_m = skipped_m;
    while (along_m < length_m) {
      const double free_m = visit(Between(begin, path[i], along_m / length_m));
      along_m += std::max(step_m, kShareOfFree * free_m);
    }
    skipped_m = along_m - length_m;
  }
  visit(path.back());
}

// What a place of the path is nearest to: its distance, and the altitude of the top there.
struct Nearest {
  double distance_m = HUGE_VAL;
  double top_m = std::nan("");
};

Nearest NearestOf(const GivenObstacle& given, const GeoPoint& place) {
  const Plane plane(place);
  const std::vector<GeoPoint>& points = given.points;
  Polygon ring;
  double highest_m = std::nan("");
  for (const GeoPoint& point : points) {
    ring.push_back(plane.At(point));
    highest_m = std::fmax(highest_m, point.altitude_m);
  }
  if (given.is_area && WindingNumber(ring, Eigen::Vector2d::Zero()) != 0) return {0.0, highest_m};
  Nearest nearest;
  const size_t num_legs = given.is_area || points.size() == 1 ? points.size() : points.size() - 1;
  for (size_t i = 0; i < num_legs; ++i) {
    const size_t next = (i + 1) % points.size();
    const Eigen::Vector2d way = ring[next] - ring[i];
    const double squared_length = way.squaredNorm();
    const double along =
        squared_length > 0.0 ? std::clamp(-ring[i].dot(way) / squared_length, 0.0, 1.0) : 0.0;
    const double distance_m = (ring[i] + along * way).norm();
    if (distance_m >= nearest.distance_m) continue;
    const double top_m =
        points[i].altitude_m + along * (points[next].altitude_m - points[i].altitude_m);
    nearest = {distance_m, given.is_area ? highest_m : top_m};
  }
  return nearest;
}

// Maps hold the obstacles above their ground (TerrainMarginOf).
bool IsMapped(const StoredSites& stored, const EmergencyRequest& request, const GeoPoint& place) {
  const auto maps = stored.storage.sites.ListMaps(BoxAroundPlace(place, 0.0));
  return std::any_of(maps.begin(), maps.end(), [&](const auto& map) {
    const auto terrain = stored.maps.TerrainOf(stored.storage, map->id);
    return terrain && terrain->CountsFor(request.flight_id);
  });
}

void CheckHard(const StoredSites& stored,
               const EmergencyRequest& request,
               const CheckedPath& path,
               const KnownObstacle& obstacle,
               PathObstacles& found) {
  const GivenObstacle& given = obstacle.given;
  const double reach_m =
      ObstacleOptions{}.position_sigma * given.position_sd_m + path.half_width_m + 0.5 * kStepM;
  bool is_top_unknown = false;
  March(path.transit, kStepM, [&](const GeoPoint& place) {
    const Nearest nearest = NearestOf(given, place);
    if (nearest.distance_m > reach_m) return nearest.distance_m - reach_m;
    if (std::isnan(nearest.top_m)) {
      is_top_unknown = is_top_unknown || !IsMapped(stored, request, place);
      return 0.0;
    }
    // The altitude of people is that of their ground.
    const double height_m =
        given.kind == ObstacleKind::kPeople ? ObstacleOptions{}.people_height_m : 0.0;
    const double top_m = AltitudeIn(given, nearest.top_m, ReferenceOf(request)) + height_m;
    const double margin_m = place.altitude_m - top_m - request.terrain_clearance_m;
    if (!found.least || margin_m < found.least->margin_m) found.least = {margin_m, given.id};
    return 0.0;
  });
  if (is_top_unknown) found.of_unknown_top.push_back(given.id);
}

bool HasHeightsAboveGround(const GivenObstacle& airspace) {
  return airspace.floor_above_ground_m || airspace.ceiling_above_ground_m;
}

// Where the ground is doubtful, the aircraft is inside.
bool IsWithinHeightsAboveGround(const GivenObstacle& airspace,
                                double altitude_m,
                                const HeightRange& ground) {
  const double least_height_m = altitude_m - ground.highest_m;
  const double most_height_m = altitude_m - ground.lowest_m;
  return least_height_m <= airspace.ceiling_above_ground_m.value_or(HUGE_VAL) &&
         most_height_m >= airspace.floor_above_ground_m.value_or(-HUGE_VAL);
}

// Bounds in the request's datum, widened by what the datums leave unknown.
bool IsWithinAltitudes(const GivenObstacle& airspace,
                       double altitude_m,
                       const AltitudeReference& request) {
  if (airspace.ceiling_m && altitude_m > AltitudeIn(airspace, *airspace.ceiling_m, request)) {
    return false;
  }
  if (!airspace.floor_m) return true;
  const double higher_m = AltitudeIn(airspace, *airspace.floor_m, request);
  const GeoPoint& place = airspace.points.front();
  const DatumDifference difference = DatumDifferenceOf(
      {airspace.altitude_datum, place.latitude_deg, place.longitude_deg, {}}, request);
  const bool is_exact =
      difference.basis == DatumBasis::kSame || difference.basis == DatumBasis::kGeoid;
  const double floor_m =
      is_exact ? higher_m : *airspace.floor_m - std::abs(difference.subtracted_m);
  return altitude_m >= floor_m;
}

// Heights above ground count from the stored maps' ground; where they show none, from the
// touchdown's altitude.
bool Enters(const StoredSites& stored,
            const EmergencyRequest& request,
            const std::vector<GeoPoint>& path,
            const GivenObstacle& airspace) {
  const std::vector<MapBelow> maps =
      HasHeightsAboveGround(airspace) ? MapsBelow(stored, request, path) : std::vector<MapBelow>{};
  const AltitudeReference reference = ReferenceOf(request);
  bool is_inside = false;
  March(path, kAirspaceStepM, [&](const GeoPoint& place) {
    if (is_inside) return HUGE_VAL;
    const double distance_m = NearestOf(airspace, place).distance_m;
    if (distance_m == 0.0 && IsWithinAltitudes(airspace, place.altitude_m, reference)) {
      const double touchdown_m = path.back().altitude_m;
      const HeightRange ground =
          GroundAltitudesAt(maps, place).value_or(HeightRange{touchdown_m, touchdown_m});
      is_inside = IsWithinHeightsAboveGround(airspace, place.altitude_m, ground);
    }
    return is_inside ? HUGE_VAL : distance_m;
  });
  return is_inside;
}

bool AreWiresKnownAt(const KnownObstacles& near, const GeoPoint& place) {
  return std::any_of(near.begin(), near.end(), [&place](const auto& known) {
    return known->given.kind == ObstacleKind::kWiresKnown &&
           NearestOf(known->given, place).distance_m == 0.0;
  });
}

}  // namespace

bool AreWiresKnown(const StoredSites& stored, const std::vector<GeoPoint>& places) {
  return std::all_of(places.begin(), places.end(), [&stored](const GeoPoint& place) {
    return AreWiresKnownAt(stored.maps.ObstaclesNear(stored.storage, BoxAroundPlace(place, 0.0)),
                           place);
  });
}

PathObstacles ObstaclesAlong(const StoredSites& stored,
                             const EmergencyRequest& request,
                             const CheckedPath& path) {
  std::vector<GeoPoint> whole = path.transit;
  whole.insert(whole.end(), path.landing.begin(), path.landing.end());
  PathObstacles found;
  const KnownObstacles near = stored.maps.ObstaclesNear(stored.storage, BoxOf(whole));
  found.are_wires_known = std::all_of(whole.begin(), whole.end(), [&near](const GeoPoint& place) {
    return AreWiresKnownAt(near, place);
  });
  for (const auto& obstacle : near) {
    if (obstacle->given.kind == ObstacleKind::kWiresKnown) continue;
    if (obstacle->IsHard()) {
      CheckHard(stored, request, path, *obstacle, found);
    } else if (Enters(stored, request, whole, obstacle->given)) {
      const GivenObstacle& given = obstacle->given;
      found.airspaces.push_back(given.id);
      found.airspace_names.push_back(given.name.empty() ? given.id : given.name);
    }
  }
  return found;
}

}  // namespace freelsd
