#include "engine/route/route.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "engine/check/check.h"

namespace freelsd {
namespace {

// Slower than that over ground counts as not advancing.
constexpr double kMinGroundSpeedMps = 0.5;

Eigen::Vector2d HorizontalWay(const GeoPoint& from, const GeoPoint& to) {
  return LocalFrame({from.latitude_deg, from.longitude_deg, 0.0})
      .WorldFromGeo({to.latitude_deg, to.longitude_deg, 0.0})
      .head<2>();
}

// `ratio` of the way, the shorter way round the earth.
GeoPoint Between(const GeoPoint& from, const GeoPoint& to, double ratio) {
  const double turn_deg = std::remainder(to.longitude_deg - from.longitude_deg, 360.0);
  return {from.latitude_deg + ratio * (to.latitude_deg - from.latitude_deg),
          std::remainder(from.longitude_deg + ratio * turn_deg, 360.0),
          from.altitude_m + ratio * (to.altitude_m - from.altitude_m)};
}

// Of the legs that have a length.
struct RouteLeg {
  // Index of the point where the leg ends.
  size_t to = 0;
  double begin_m = 0.0;
  double length_m = 0.0;
  double end_m() const { return begin_m + length_m; }
};

std::vector<RouteLeg> LegsOf(const std::vector<GeoPoint>& route) {
  std::vector<RouteLeg> legs;
  double length_m = 0.0;
  for (size_t i = 1; i < route.size(); ++i) {
    const double leg_m = HorizontalWay(route[i - 1], route[i]).norm();
    if (leg_m <= 0.0) continue;
    legs.push_back({i, length_m, leg_m});
    length_m += leg_m;
  }
  if (legs.empty()) throw std::invalid_argument("route: must have a length");
  return legs;
}

GeoPoint PlaceOn(const std::vector<GeoPoint>& route, const RouteLeg& leg, double distance_m) {
  return Between(route[leg.to - 1], route[leg.to], (distance_m - leg.begin_m) / leg.length_m);
}

// A leg may bend on the map: its direction is that of the next metres.
double HeadingAt(const std::vector<GeoPoint>& route, const RouteLeg& leg, double distance_m) {
  const double ahead_m = std::min(1.0, leg.length_m);
  const double begin_m = std::min(distance_m, leg.end_m() - ahead_m);
  const Eigen::Vector2d way =
      HorizontalWay(PlaceOn(route, leg, begin_m), PlaceOn(route, leg, begin_m + ahead_m));
  const double heading_deg = DegFromRad(HeadingOf(way));
  return heading_deg < 0.0 ? heading_deg + 360.0 : heading_deg;
}

// The aircraft heads into the wind so that it stays on the leg.
double GroundSpeed(const Eigen::Vector2d& way, double airspeed_mps, const Eigen::Vector2d& wind) {
  const Eigen::Vector2d along = way.normalized();
  const double across_mps = along.x() * wind.y() - along.y() * wind.x();
  const double rest = airspeed_mps * airspeed_mps - across_mps * across_mps;
  return rest <= 0.0 ? 0.0 : along.dot(wind) + std::sqrt(rest);
}

// Share of the whole change at this distance.
double ShareAt(const ChangedPart& part, double lead_m, double distance_m) {
  if (lead_m <= 0.0) return 0.0;
  return std::clamp(
      std::min(distance_m - part.begin_m, part.end_m - distance_m) / lead_m, 0.0, 1.0);
}

double LeadOf(const RouteChange& change, const RouteOptions& options) {
  return std::max(std::abs(change.climb_m) / change.climb_slope,
                  change.offset_m.norm() / options.max_offset_slope);
}

GeoPoint Moved(const GeoPoint& place, const RouteChange& change, double share) {
  if (share <= 0.0) return place;
  const Eigen::Vector2d offset = share * change.offset_m;
  GeoPoint moved = LocalFrame({place.latitude_deg, place.longitude_deg, 0.0})
                       .GeoFromWorld({offset.x(), offset.y(), 0.0});
  moved.altitude_m = place.altitude_m + share * change.climb_m;
  return moved;
}

bool IsSame(const GeoPoint& a, const GeoPoint& b) {
  return a.latitude_deg == b.latitude_deg && a.longitude_deg == b.longitude_deg &&
         a.altitude_m == b.altitude_m;
}

}  // namespace

void RouteOptions::Check() const {
  const FieldCheck check("route");
  check.Inside("moment_period_s", moment_period_s, 0.1, 60);
  check.Inside("max_num_moments", max_num_moments, 2, 100000);
  check.Inside("max_offset_slope", max_offset_slope, 0.05, 2);
}

std::vector<RouteMoment> MomentsOf(const std::vector<GeoPoint>& route,
                                   double airspeed_mps,
                                   const Eigen::Vector2d& wind_in_world,
                                   const RouteOptions& options) {
  options.Check();
  std::vector<RouteMoment> moments;
  double begin_s = 0.0;
  for (const RouteLeg& leg : LegsOf(route)) {
    const double speed_mps =
        GroundSpeed(HorizontalWay(route[leg.to - 1], route[leg.to]), airspeed_mps, wind_in_world);
    if (speed_mps < kMinGroundSpeedMps) {
      throw std::invalid_argument("route[" + std::to_string(leg.to) +
                                  "]: cannot be reached in this wind at this airspeed");
    }
    const double end_s = begin_s + leg.length_m / speed_mps;
    if (end_s > options.max_num_moments * options.moment_period_s) {
      throw std::invalid_argument(
          "route: takes more than " +
          std::to_string(std::lround(options.max_num_moments * options.moment_period_s)) + " s");
    }
    while (true) {
      const double time_s = static_cast<double>(moments.size()) * options.moment_period_s;
      if (time_s >= end_s) break;
      const double distance_m = leg.begin_m + (time_s - begin_s) * speed_mps;
      moments.push_back(
          {time_s, PlaceOn(route, leg, distance_m), HeadingAt(route, leg, distance_m), distance_m});
    }
    begin_s = end_s;
  }
  return moments;
}

ChangedPart PartOf(const std::vector<GeoPoint>& route,
                   const RouteChange& change,
                   const RouteOptions& options) {
  const double length_m = LegsOf(route).back().end_m();
  const double lead_m = LeadOf(change, options);
  ChangedPart part;
  part.begin_m = std::max(0.0, change.from_m - lead_m);
  part.end_m = std::min(length_m, change.to_m + lead_m);
  const double middle_m = 0.5 * (part.begin_m + part.end_m);
  part.whole_from_m = std::min(part.begin_m + lead_m, middle_m);
  part.whole_to_m = std::max(part.end_m - lead_m, middle_m);
  return part;
}

std::vector<GeoPoint> Changed(const std::vector<GeoPoint>& route,
                              const RouteChange& change,
                              const RouteOptions& options) {
  const ChangedPart part = PartOf(route, change, options);
  const double lead_m = LeadOf(change, options);
  std::vector<GeoPoint> changed{route.front()};
  const auto add = [&](const GeoPoint& place, double distance_m) {
    const GeoPoint moved = Moved(place, change, ShareAt(part, lead_m, distance_m));
    if (!IsSame(moved, changed.back())) changed.push_back(moved);
  };
  for (const RouteLeg& leg : LegsOf(route)) {
    add(route[leg.to - 1], leg.begin_m);
    for (const double corner_m : {part.begin_m, part.whole_from_m, part.whole_to_m, part.end_m}) {
      if (corner_m > leg.begin_m && corner_m < leg.end_m()) {
        add(PlaceOn(route, leg, corner_m), corner_m);
      }
    }
    add(route[leg.to], leg.end_m());
  }
  return changed;
}

}  // namespace freelsd
