#include "engine/geometry/local_frame.h"

namespace freelsd {

LocalFrame::LocalFrame(const GeoPoint& origin)
    : origin_(origin), cartesian_(origin.latitude_deg, origin.longitude_deg, origin.altitude_m) {}

Eigen::Vector3d LocalFrame::WorldFromGeo(const GeoPoint& point) const {
  Eigen::Vector3d point_in_world;
  cartesian_.Forward(point.latitude_deg,
                     point.longitude_deg,
                     point.altitude_m,
                     point_in_world.x(),
                     point_in_world.y(),
                     point_in_world.z());
  return point_in_world;
}

GeoPoint LocalFrame::GeoFromWorld(const Eigen::Vector3d& point_in_world) const {
  GeoPoint point;
  cartesian_.Reverse(point_in_world.x(),
                     point_in_world.y(),
                     point_in_world.z(),
                     point.latitude_deg,
                     point.longitude_deg,
                     point.altitude_m);
  return point;
}

}  // namespace freelsd
