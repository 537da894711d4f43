// QGroundControl's .plan, version 1, with the fixed-wing landing pattern of the best site.
#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "api/export/sites/site_export.h"

namespace freelsd {
namespace {

// Radius of the sphere on which QGroundControl and PX4 measure.
constexpr double kSphereRadiusM = 6371007.2;
// Allowed differences between the site and the values that the program computes from the plan.
const double kHeadingTolerance = RadFromDeg(0.1);
const double kSlopeTolerance = RadFromDeg(0.05);

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

// The program computes heading and glide slope from the circle's tangent through the touchdown, on
// its sphere. There, metres are up to 0.6 % off, by different amounts northwards and eastwards.
// Positions stay exact to the millimetre. The radius may change by a percent: if it makes the
// heading exact, the slope can be 0.055 deg off; unchanged, the heading is half a degree off. So
// the radius minimises the sum of squared errors, each in units of its tolerance.
double RadiusOnSphere(const StoredSite& site) {
  const FinalPlaces& ours = *site.final_places;
  const SphericalLeg leg = LegOnSphere(site.touchdown, ours.loiter_center);
  const double turn = leg.azimuth - RadFromDeg(ours.heading_deg + 180.0);
  const double radius_m = leg.distance_m * std::abs(std::sin(turn));
  const double distance_m = leg.distance_m * std::cos(turn);
  // Derivatives of d = sqrt(D^2 - R^2), of the tangent's angle asin(R / D) and of the slope
  // atan(h / d).
  const double slope_per_m =
      -ours.height_m / (distance_m * distance_m + ours.height_m * ours.height_m);
  const double heading_errors_per_m = 1.0 / distance_m / kHeadingTolerance;
  const double slope_errors_per_m = slope_per_m * -radius_m / distance_m / kSlopeTolerance;
  const double slope_errors =
      (std::atan2(ours.height_m, distance_m) - std::atan2(ours.height_m, ours.distance_m)) /
      kSlopeTolerance;
  return radius_m - slope_errors_per_m * slope_errors /
                        (heading_errors_per_m * heading_errors_per_m +
                         slope_errors_per_m * slope_errors_per_m);
}

nlohmann::json Coordinate(const GeoPoint& place, const AltitudeFrame& frame) {
  return {place.latitude_deg, place.longitude_deg, frame.Of(place.altitude_m)};
}

// Without a known airspeed the vehicle keeps its own.
nlohmann::json LandingPattern(const StoredSite& site, const AltitudeFrame& frame) {
  nlohmann::json pattern{
      {"type", "ComplexItem"},
      {"complexItemType", "fwLandingPattern"},
      {"version", 2},
      {"altitudesAreRelative", frame.is_above_home},
      {"landCoordinate", Coordinate(site.touchdown, frame)},
      {"landingApproachCoordinate", Coordinate(site.final_places->loiter_center, frame)},
      {"loiterRadius", RadiusOnSphere(site)},
      {"loiterClockwise", site.final_places->is_right_turn},
      {"useLoiterToAlt", true},
      {"useDoChangeSpeed", site.landing_airspeed_mps.has_value()},
      {"valueSetIsDistance", true},
      {"stopTakingPhotos", false},
      {"stopVideoPhotos", false}};
  if (site.landing_airspeed_mps) pattern["finalApproachSpeed"] = *site.landing_airspeed_mps;
  return pattern;
}

// The format needs a home; the vehicle replaces it by its own. Home's altitude is above mean sea
// level, or null if unknown.
nlohmann::json PlannedHome(const StoredSite& site, const ExportOptions& options) {
  nlohmann::json altitude;
  if (site.altitude_datum == "amsl") {
    altitude = options.home_altitude_m.value_or(site.touchdown.altitude_m);
  }
  return {site.touchdown.latitude_deg, site.touchdown.longitude_deg, altitude};
}

// The format's rally points are above home, so without home there are none.
nlohmann::json RallyPoints(const std::vector<StoredSite>& sites, const ExportOptions& options) {
  nlohmann::json points = nlohmann::json::array();
  if (!options.home_altitude_m) return points;
  const AltitudeFrame frame = FrameAboveHome(options);
  for (const StoredSite& site : sites) {
    GeoPoint place = site.touchdown;
    place.altitude_m += kRallyHeightM;
    points.push_back(Coordinate(place, frame));
  }
  return points;
}

// What people must know before they fly the plan.
std::vector<std::string> WarningsOf(const StoredSite& site) {
  std::vector<std::string> warnings = site.warnings;
  if (site.verdict != "unverified") return warnings;
  std::string text = "UNVERIFIED: no hazard is known, but not everything was measured";
  if (site.unseen_ratio.value_or(0.0) > 0.0) {
    const double percent = std::max(1.0, 100.0 * *site.unseen_ratio);
    text +=
        ": along " + FixedText(percent, 0) + " % of the loiter circle some ground is not measured";
  }
  warnings.insert(warnings.begin(), text);
  return warnings;
}

// When the ground was photographed; null if unknown.
nlohmann::json WithAge(nlohmann::json object, const StoredSite& site) {
  object["last_seen_at"] = nullptr;
  object["age_s"] = nullptr;
  if (site.last_seen_at) object["last_seen_at"] = *site.last_seen_at;
  if (site.age_s) object["age_s"] = *site.age_s;
  return object;
}

// For people. `sites` begins with the site to land on.
nlohmann::json Remarks(const std::vector<StoredSite>& sites, const AltitudeFrame& frame) {
  const StoredSite& site = sites.front();
  nlohmann::json rally_points = nlohmann::json::array();
  for (const StoredSite& each : sites) {
    if (!frame.is_above_home) continue;
    rally_points.push_back(WithAge({{"site_id", each.id}, {"name", each.Name()}}, each));
  }
  return WithAge({{"site_id", site.id},
                  {"name", site.Name()},
                  {"verdict", site.verdict},
                  {"summary", site.summary.value_or("")},
                  {"warnings", WarningsOf(site)},
                  {"rally_points", rally_points},
                  {"heading_deg", site.final_places->heading_deg},
                  {"altitude_datum", site.altitude_datum},
                  {"altitudes", frame.is_above_home ? "above home" : "above mean sea level"}},
                 site);
}

}  // namespace

std::string PlanFile(const std::vector<StoredSite>& sites, const ExportOptions& options) {
  const std::vector<StoredSite> safe = SafeSites(sites, true);
  const StoredSite& best = safe.front();
  const AltitudeFrame frame = FrameOf(safe, options);
  QgcPlan plan;
  plan.is_above_home = frame.is_above_home;
  plan.home = PlannedHome(best, options);
  plan.items.push_back(LandingPattern(best, frame));
  plan.rally_points = RallyPoints(safe, options);
  plan.remarks = Remarks(safe, frame);
  return QgcPlanFile(plan, options.firmware);
}

}  // namespace freelsd
