#include "api/export/utm.h"

#include <array>
#include <vector>

#include <Eigen/QR>
#include <GeographicLib/UTMUPS.hpp>

#include "api/export/layers/layers.h"

namespace freelsd {
namespace {

// EPSG codes of WGS84 / UTM zone 1 north and south less one, and of UPS north and south.
constexpr int kEpsgUtmNorth = 32600;
constexpr int kEpsgUtmSouth = 32700;
constexpr int kEpsgUpsNorth = 32661;
constexpr int kEpsgUpsSouth = 32761;

}  // namespace

int Utm::Epsg() const {
  if (zone == 0) return is_north ? kEpsgUpsNorth : kEpsgUpsSouth;
  return (is_north ? kEpsgUtmNorth : kEpsgUtmSouth) + zone;
}

Utm ZoneOf(const GeoPoint& origin) {
  Utm utm;
  double easting, northing;
  GeographicLib::UTMUPS::Forward(
      origin.latitude_deg, origin.longitude_deg, utm.zone, utm.is_north, easting, northing);
  return utm;
}

Eigen::Vector2d UtmFromGeo(const Utm& utm, const GeoPoint& place) {
  int zone;
  bool is_north;
  double easting, northing;
  GeographicLib::UTMUPS::Forward(
      place.latitude_deg, place.longitude_deg, zone, is_north, easting, northing, utm.zone);
  if (is_north != utm.is_north) {
    northing += GeographicLib::UTMUPS::UTMShift() * (is_north ? 1.0 : -1.0);
  }
  return {easting, northing};
}

GeoPoint GeoFromUtm(const Utm& utm, const Eigen::Vector2d& place_in_utm) {
  GeoPoint place;
  GeographicLib::UTMUPS::Reverse(utm.zone,
                                 utm.is_north,
                                 place_in_utm.x(),
                                 place_in_utm.y(),
                                 place.latitude_deg,
                                 place.longitude_deg);
  return place;
}

Eigen::Matrix<double, 2, 3> UtmFromPixel(const Grid& grid,
                                         const Utm& utm,
                                         const LocalFrame& frame) {
  const std::vector<Eigen::Vector2d> corners = OuterCorners(grid);
  const double width = grid.num_cols, height = grid.num_rows;
  const std::array<Eigen::Vector3d, 4> pixels{Eigen::Vector3d(0, 0, 1),
                                              Eigen::Vector3d(width, 0, 1),
                                              Eigen::Vector3d(width, height, 1),
                                              Eigen::Vector3d(0, height, 1)};
  Eigen::Matrix<double, 4, 3> pixel_rows;
  Eigen::Matrix<double, 4, 2> places;
  const Eigen::Vector2d base = UtmFromGeo(utm, frame.origin());
  for (int i = 0; i < 4; ++i) {
    pixel_rows.row(i) = pixels[i].transpose();
    const GeoPoint corner = frame.GeoFromWorld({corners[i].x(), corners[i].y(), 0.0});
    places.row(i) = (UtmFromGeo(utm, corner) - base).transpose();
  }
  const Eigen::Matrix<double, 3, 2> solution = pixel_rows.colPivHouseholderQr().solve(places);
  Eigen::Matrix<double, 2, 3> utm_from_pixel = solution.transpose();
  utm_from_pixel.col(2) += base;
  return utm_from_pixel;
}

}  // namespace freelsd
