#include "server/recall/path_obstacles.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/obstacles/obstacles.h"

namespace freelsd {
namespace {

constexpr double kStepM = 5.0;
constexpr double kAirspaceStepM = 25.0;
constexpr double kMetresPerDegree = 111195.0;  // of latitude, on a sphere

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

bool IsInBox(const GeoPoint& place, const BoundingBox& box) {
  const double east_deg = box.west_deg + std::remainder(place.longitude_deg - box.west_deg, 360.0);
  const bool is_between = east_deg >= box.west_deg - 1e-9 && east_deg <= box.east_deg;
  return is_between && place.latitude_deg >= box.south_deg && place.latitude_deg <= box.north_deg;
}

// Calls for points of the path at most a step apart, within the box.
template <typename Visit>
void AlongIn(const std::vector<GeoPoint>& path,
             const BoundingBox& box,
             double step_m,
             const Visit& visit) {
  for (size_t i = 0; i < path.size(); ++i) {
    const GeoPoint& begin = path[i > 0 ? i - 1 : 0];
    const double length_m = Plane(begin).At(path[i]).norm();
    const int num_steps = std::max(1, static_cast<int>(std::ceil(length_m / step_m)));
    for (int step = 1; step <= num_steps; ++step) {
      const GeoPoint place = Between(begin, path[i], static_cast<double>(step) / num_steps);
      if (IsInBox(place, box)) visit(place);
    }
  }
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
bool IsMapped(const StoredSites& stored, const GeoPoint& place) {
  return !stored.storage.sites.ListMaps(BoxAroundPlace(place, 0.0)).empty();
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
  AlongIn(path.transit, obstacle.box, kStepM, [&](const GeoPoint& place) {
    const Nearest nearest = NearestOf(given, place);
    if (nearest.distance_m > reach_m) return;
    if (std::isnan(nearest.top_m)) {
      is_top_unknown = is_top_unknown || !IsMapped(stored, place);
      return;
    }
    const double top_m = AltitudeIn(given, nearest.top_m, ReferenceOf(request));
    const double margin_m = place.altitude_m - top_m - request.terrain_clearance_m;
    if (!found.least || margin_m < found.least->margin_m) found.least = {margin_m, given.id};
  });
  if (is_top_unknown) found.of_unknown_top.push_back(given.id);
}

// Bounds in the request's datum, widened by what the datums leave unknown.
bool IsWithinHeights(const GivenObstacle& airspace,
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

bool Enters(const std::vector<GeoPoint>& path,
            const KnownObstacle& airspace,
            const AltitudeReference& request) {
  bool is_inside = false;
  AlongIn(path, airspace.box, kAirspaceStepM, [&](const GeoPoint& place) {
    if (is_inside || !IsWithinHeights(airspace.given, place.altitude_m, request)) return;
    const Plane plane(place);
    Polygon ring;
    for (const GeoPoint& point : airspace.given.points) ring.push_back(plane.At(point));
    is_inside = WindingNumber(ring, Eigen::Vector2d::Zero()) != 0;
  });
  return is_inside;
}

}  // namespace

PathObstacles ObstaclesAlong(const StoredSites& stored,
                             const EmergencyRequest& request,
                             const CheckedPath& path) {
  std::vector<GeoPoint> whole = path.transit;
  whole.insert(whole.end(), path.landing.begin(), path.landing.end());
  PathObstacles found;
  for (const auto& obstacle : stored.maps.ObstaclesNear(stored.storage, BoxOf(whole))) {
    if (obstacle->IsHard()) {
      CheckHard(stored, request, path, *obstacle, found);
    } else if (Enters(whole, *obstacle, ReferenceOf(request))) {
      found.airspaces.push_back(obstacle->given.id);
    }
  }
  return found;
}

}  // namespace freelsd
