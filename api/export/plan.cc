// QGroundControl's .plan, version 1, with the fixed-wing landing pattern of the best site.
#include <cmath>

#include "api/export/site_export.h"

namespace freelsd {
namespace {

// QGroundControl and PX4 measure on a sphere.
constexpr double kSphereRadiusM = 6371007.2;
// MAV_AUTOPILOT_PX4, vehicle class fixed wing.
constexpr int kFirmwareType = 12;
constexpr int kVehicleType = 1;
// Shown only; a pilot's own numbers win.
constexpr double kCruiseSpeedMps = 15.0;
constexpr double kHoverSpeedMps = 5.0;

struct SphericalLeg {
  double distance_m;
  double azimuth;
};

SphericalLeg LegOnSphere(const GeoPoint& from, const GeoPoint& to) {
  const double from_latitude = RadFromDeg(from.latitude_deg);
  const double to_latitude = RadFromDeg(to.latitude_deg);
  const double east = RadFromDeg(to.longitude_deg - from.longitude_deg);
  const double half_north = std::sin(0.5 * (to_latitude - from_latitude));
  const double half_east = std::sin(0.5 * east);
  const double haversine = half_north * half_north +
                           std::cos(from_latitude) * std::cos(to_latitude) * half_east * half_east;
  const double azimuth =
      std::atan2(std::sin(east) * std::cos(to_latitude),
                 std::cos(from_latitude) * std::sin(to_latitude) -
                     std::sin(from_latitude) * std::cos(to_latitude) * std::cos(east));
  return {2.0 * kSphereRadiusM * std::asin(std::sqrt(haversine)), azimuth};
}

// The program finds the heading again as the circle's tangent through the touchdown, on its sphere.
// Places are ours to the millimetre; the radius (within a percent of ours) is the one that makes
// that tangent our heading, which the true one misses by up to half a degree.
double RadiusOnSphere(const SitePlaces& site) {
  const SphericalLeg leg = LegOnSphere(site.touchdown, site.final_places->loiter_center);
  const double back = RadFromDeg(site.final_places->heading_deg + 180.0);
  return leg.distance_m * std::abs(std::sin(leg.azimuth - back));
}

nlohmann::json Coordinate(const GeoPoint& place, const AltitudeFrame& frame) {
  return {place.latitude_deg, place.longitude_deg, frame.Of(place.altitude_m)};
}

nlohmann::json LandingPattern(const SitePlaces& site, const AltitudeFrame& frame) {
  return {{"type", "ComplexItem"},
          {"complexItemType", "fwLandingPattern"},
          {"version", 2},
          {"altitudesAreRelative", frame.is_above_home},
          {"landCoordinate", Coordinate(site.touchdown, frame)},
          {"landingApproachCoordinate", Coordinate(site.final_places->loiter_center, frame)},
          {"loiterRadius", RadiusOnSphere(site)},
          {"loiterClockwise", site.final_places->is_right_turn},
          {"useLoiterToAlt", true},
          {"valueSetIsDistance", true},
          {"stopTakingPhotos", false},
          {"stopVideoPhotos", false}};
}

// The format wants a home; the vehicle puts its own in its place. Its altitude is above mean sea
// level, null where that is not known.
nlohmann::json PlannedHome(const SitePlaces& site, const ExportOptions& options) {
  nlohmann::json altitude;
  if (site.altitude_datum == "amsl") {
    altitude = options.home_altitude_m.value_or(site.touchdown.altitude_m);
  }
  return {site.touchdown.latitude_deg, site.touchdown.longitude_deg, altitude};
}

// Rally points are above home in this format: without home there are none.
nlohmann::json RallyPoints(const std::vector<SitePlaces>& sites, const ExportOptions& options) {
  nlohmann::json points = nlohmann::json::array();
  if (!options.home_altitude_m) return points;
  const AltitudeFrame frame = FrameAboveHome(options);
  for (const SitePlaces& site : sites) {
    GeoPoint place = site.touchdown;
    place.altitude_m += kRallyHeightM;
    points.push_back(Coordinate(place, frame));
  }
  return points;
}

// Keys that the program does not know it passes over; people read them.
nlohmann::json Remarks(const SitePlaces& site, const AltitudeFrame& frame) {
  return {{"site_id", site.id},
          {"name", site.Name()},
          {"verdict", site.verdict},
          {"summary", site.properties.value("summary", "")},
          {"heading_deg", site.final_places->heading_deg},
          {"altitude_datum", site.altitude_datum},
          {"altitudes", frame.is_above_home ? "above home" : "above mean sea level"}};
}

}  // namespace

std::string PlanFile(const std::vector<StoredSite>& stored, const ExportOptions& options) {
  const std::vector<SitePlaces> sites = SafeSites(stored, true);
  const SitePlaces& best = sites.front();
  const AltitudeFrame frame = FrameOf(sites, options);
  nlohmann::json items = nlohmann::json::array();
  items.push_back(LandingPattern(best, frame));
  const nlohmann::json mission{{"version", 2},
                               {"firmwareType", kFirmwareType},
                               {"vehicleType", kVehicleType},
                               {"cruiseSpeed", kCruiseSpeedMps},
                               {"hoverSpeed", kHoverSpeedMps},
                               {"globalPlanAltitudeMode", frame.is_above_home ? 1 : 2},
                               {"plannedHomePosition", PlannedHome(best, options)},
                               {"items", items}};
  const nlohmann::json fence{
      {"version", 2}, {"polygons", nlohmann::json::array()}, {"circles", nlohmann::json::array()}};
  const nlohmann::json plan{
      {"fileType", "Plan"},
      {"version", 1},
      {"groundStation", "QGroundControl"},
      {"mission", mission},
      {"geoFence", fence},
      {"rallyPoints", {{"version", 2}, {"points", RallyPoints(sites, options)}}},
      {"freelsd", Remarks(best, frame)}};
  return plan.dump(2) + "\n";
}

}  // namespace freelsd
