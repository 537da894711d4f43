#include "api/export/map/outline.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace freelsd {
namespace {

constexpr int kPlacesPerEdge = 8;

GeoPoint NearOrigin(const Eigen::Vector2d& place, const LocalFrame& local_frame) {
  GeoPoint geo = local_frame.GeoFromWorld({place.x(), place.y(), 0.0});
  const double turns = (geo.longitude_deg - local_frame.origin().longitude_deg) / 360.0;
  geo.longitude_deg -= 360.0 * std::round(turns);
  return geo;
}

}  // namespace

void CheckExtent(const WorldBox& extent) {
  if (extent.min_in_world.allFinite() && extent.max_in_world.allFinite() &&
      (extent.min_in_world.array() < extent.max_in_world.array()).all()) {
    return;
  }
  throw std::invalid_argument("map.extent: the box is empty or not finite");
}

std::vector<GeoPoint> OutlineOf(const WorldBox& extent, const LocalFrame& local_frame) {
  const Eigen::Vector2d &low = extent.min_in_world, &high = extent.max_in_world;
  std::vector<GeoPoint> places;
  for (int i = 0; i <= kPlacesPerEdge; ++i) {
    const Eigen::Vector2d at = low + (high - low) * i / kPlacesPerEdge;
    for (const Eigen::Vector2d& place : {Eigen::Vector2d(at.x(), low.y()),
                                         Eigen::Vector2d(at.x(), high.y()),
                                         Eigen::Vector2d(low.x(), at.y()),
                                         Eigen::Vector2d(high.x(), at.y())}) {
      places.push_back(NearOrigin(place, local_frame));
    }
  }
  return places;
}

GeoBounds BoundsOf(const WorldBox& extent, const LocalFrame& local_frame) {
  const std::vector<GeoPoint> outline = OutlineOf(extent, local_frame);
  GeoBounds bounds{outline[0].longitude_deg,
                   outline[0].latitude_deg,
                   outline[0].longitude_deg,
                   outline[0].latitude_deg};
  for (const GeoPoint& place : outline) {
    bounds.west_deg = std::min(bounds.west_deg, place.longitude_deg);
    bounds.east_deg = std::max(bounds.east_deg, place.longitude_deg);
    bounds.south_deg = std::min(bounds.south_deg, place.latitude_deg);
    bounds.north_deg = std::max(bounds.north_deg, place.latitude_deg);
  }
  if (bounds.west_deg < -180.0 || bounds.east_deg > 180.0) {
    bounds.west_deg = -180.0;
    bounds.east_deg = 180.0;
  }
  return bounds;
}

GeoPoint CenterOf(const WorldBox& extent, const LocalFrame& local_frame) {
  const Eigen::Vector2d center = 0.5 * (extent.min_in_world + extent.max_in_world);
  return local_frame.GeoFromWorld({center.x(), center.y(), 0.0});
}

}  // namespace freelsd
