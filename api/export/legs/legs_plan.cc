// QGroundControl's .plan, version 1: one survey per leg. Its items fly the leg exactly; its polygon
// is so narrow that the program makes the same leg of it when somebody edits the survey.
#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "api/export/legs/legs.h"
#include "api/export/sites/sites.h"
#include "api/geojson.h"

namespace freelsd {
namespace {

constexpr int kNavWaypoint = 16;
constexpr int kSetTriggerDistance = 206;
// MAV_FRAME_GLOBAL, MAV_FRAME_MISSION, MAV_FRAME_GLOBAL_RELATIVE_ALT.
constexpr int kAbsoluteFrame = 0;
constexpr int kMissionFrame = 2;
constexpr int kRelativeFrame = 3;
// Width of a survey's polygon, as a share of the distance between its transects.
constexpr double kPolygonRatio = 0.5;

// How the legs are written.
struct LegsFile {
  const NextLook& look;
  const FlightContext& context;
  // Altitude that counts as zero, and whether it is home's.
  double zero_m = 0.0;
  bool is_above_home = false;
  int num_items = 0;

  double AltitudeOfLeg(const LookLeg& leg) const {
    return AltitudeOf(leg.from_in_world, context.local_frame) - zero_m;
  }
};

nlohmann::json SimpleItem(LegsFile& file, int command, int frame, const nlohmann::json& params) {
  return {{"type", "SimpleItem"},
          {"autoContinue", true},
          {"command", command},
          {"doJumpId", ++file.num_items},
          {"frame", frame},
          {"params", params}};
}

nlohmann::json WaypointItem(LegsFile& file, const GeoPoint& place, double altitude_m) {
  const nlohmann::json params{
      0, 0, 0, nullptr, place.latitude_deg, place.longitude_deg, altitude_m};
  return SimpleItem(
      file, kNavWaypoint, file.is_above_home ? kRelativeFrame : kAbsoluteFrame, params);
}

nlohmann::json TriggerItem(LegsFile& file, double distance_m) {
  return SimpleItem(file, kSetTriggerDistance, kMissionFrame, {distance_m, 0, 1, 0, 0, 0, 0});
}

GeoPoint PlaceOn(const LookLeg& leg, double before_m, double aside_m, const LocalFrame& frame) {
  const Eigen::Vector2d ahead = DirectionOf(leg.heading), right(ahead.y(), -ahead.x());
  Eigen::Vector3d place = leg.from_in_world;
  place.head<2>() += aside_m * right - before_m * ahead;
  return frame.GeoFromWorld(place);
}

double LengthOf(const LookLeg& leg) { return (leg.to_in_world - leg.from_in_world).norm(); }

nlohmann::json Corner(const GeoPoint& place) { return {place.latitude_deg, place.longitude_deg}; }

// The aircraft flies straight for the radius of a turn before and after the leg.
nlohmann::json TransectOf(LegsFile& file, const LookLeg& leg) {
  const LocalFrame& frame = file.context.local_frame;
  const double lead_m = file.look.turn_radius_m, altitude_m = file.AltitudeOfLeg(leg);
  const GeoPoint places[] = {PlaceOn(leg, lead_m, 0.0, frame),
                             PlaceOn(leg, 0.0, 0.0, frame),
                             PlaceOn(leg, -LengthOf(leg), 0.0, frame),
                             PlaceOn(leg, -LengthOf(leg) - lead_m, 0.0, frame)};
  nlohmann::json items = nlohmann::json::array(), points = nlohmann::json::array();
  for (int i = 0; i < 4; ++i) {
    items.push_back(WaypointItem(file, places[i], altitude_m));
    points.push_back(Corner(places[i]));
    if (i == 1) items.push_back(TriggerItem(file, file.look.photo_spacing_m));
    if (i == 2) items.push_back(TriggerItem(file, 0.0));
  }
  const nlohmann::json camera{{"version", 1},
                              {"CameraName", "Manual (no camera specs)"},
                              {"DistanceToSurface", altitude_m},
                              {"DistanceToSurfaceRelative", file.is_above_home},
                              {"AdjustedFootprintFrontal", file.look.photo_spacing_m},
                              {"AdjustedFootprintSide", file.look.photo_extent_m.y()}};
  return {{"version", 1},
          {"TurnAroundDistance", lead_m},
          {"CameraTriggerInTurnAround", false},
          {"HoverAndCapture", false},
          {"Refly90Degrees", false},
          {"FollowTerrain", false},
          {"CameraShots", static_cast<int>(LengthOf(leg) / file.look.photo_spacing_m) + 1},
          {"CameraCalc", camera},
          {"VisualTransectPoints", points},
          {"Items", items}};
}

nlohmann::json SurveyItem(LegsFile& file, const LookLeg& leg) {
  const LocalFrame& frame = file.context.local_frame;
  const double half_m = 0.5 * kPolygonRatio * file.look.photo_extent_m.y();
  nlohmann::json polygon = nlohmann::json::array();
  for (const auto& [before_m, aside_m] : {std::pair(0.0, -half_m),
                                          std::pair(-LengthOf(leg), -half_m),
                                          std::pair(-LengthOf(leg), half_m),
                                          std::pair(0.0, half_m)}) {
    polygon.push_back(Corner(PlaceOn(leg, before_m, aside_m, frame)));
  }
  return {{"type", "ComplexItem"},
          {"complexItemType", "survey"},
          {"version", 5},
          {"angle", DegFromRad(leg.heading)},
          {"entryLocation", 0},
          {"flyAlternateTransects", false},
          {"splitConcavePolygons", false},
          {"polygon", polygon},
          {"TransectStyleComplexItem", TransectOf(file, leg)}};
}

// Where the first leg begins. The vehicle replaces it by its own home.
nlohmann::json HomeOf(const LegsFile& file, const ExportOptions& options) {
  const GeoPoint first =
      file.context.local_frame.GeoFromWorld(file.look.legs.front().from_in_world);
  nlohmann::json altitude;
  if (file.context.altitude_datum == "amsl") {
    altitude = options.home_altitude_m.value_or(first.altitude_m - file.look.height_above_ground_m);
  }
  return {first.latitude_deg, first.longitude_deg, altitude};
}

LegsFile FileOf(const NextLook& look, const FlightContext& context, const ExportOptions& options) {
  if (look.legs.empty()) {
    throw ApiError("NothingToLookAt", "no leg is expected to turn a place landable");
  }
  RequireAltitudes(context, options);
  return {
      look, context, options.home_altitude_m.value_or(0.0), options.home_altitude_m.has_value()};
}

}  // namespace

void RequireAltitudes(const FlightContext& context, const ExportOptions& options) {
  if (options.home_altitude_m || context.altitude_datum == "amsl") return;
  throw ApiError("AltitudeUnknown",
                 "the altitudes of the flight are not known to be above mean sea level: "
                 "home_altitude_m is needed",
                 {{"home_altitude_m", "is missing"}});
}

std::string LegsPlan(const NextLook& look,
                     const FlightContext& context,
                     const ExportOptions& options) {
  LegsFile file = FileOf(look, context, options);
  QgcPlan plan;
  plan.is_above_home = file.is_above_home;
  plan.home = HomeOf(file, options);
  for (const LookLeg& leg : look.legs) plan.items.push_back(SurveyItem(file, leg));
  plan.remarks = {{"flight_id", context.flight_id},
                  {"expected_gain", Rounded(look.expected_gain)},
                  {"altitude_datum", context.altitude_datum},
                  {"altitudes", file.is_above_home ? "above home" : "above mean sea level"}};
  return QgcPlanFile(plan, options.firmware);
}

}  // namespace freelsd
