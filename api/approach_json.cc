#include <cmath>

#include "api/geojson.h"
#include "api/plan_json.h"

namespace freelsd {
namespace {

// Legs of the drawn loiter circle: 5 degrees each; for a radius of 180 m they miss it by 0.2 m.
constexpr int kNumLoiterLegs = 72;

nlohmann::json ProfileJson(const Approach& approach, const LocalFrame& local_frame) {
  const ApproachProfile& profile = approach.profile;
  const Eigen::Vector2d back = -DirectionOf(approach.heading);
  nlohmann::json distance = nlohmann::json::array(), path = distance, terrain = distance,
                 clearance = distance;
  for (size_t i = 0; i < profile.distance.size(); ++i) {
    const Eigen::Vector2d place =
        approach.touchdown_in_world.head<2>() + back * profile.distance[i];
    const auto altitude = [&](double height) {
      return AltitudeOf({place.x(), place.y(), height}, local_frame);
    };
    const double ground = profile.terrain_height[i];
    distance.push_back(Rounded(profile.distance[i]));
    path.push_back(Rounded(altitude(profile.path_height[i])));
    // GeographicLib does not promise to return NaN for NaN, so unseen ground is handled here.
    terrain.push_back(std::isfinite(ground) ? Rounded(altitude(ground)) : nlohmann::json(nullptr));
    clearance.push_back(Rounded(profile.path_height[i] - ground));
  }
  return {{"distance_m", distance},
          {"path_m", path},
          {"terrain_m", terrain},
          {"clearance_m", clearance}};
}

nlohmann::json ObstacleJson(const std::optional<PathObstacle>& obstacle,
                            const LocalFrame& local_frame) {
  if (!obstacle) return nullptr;
  nlohmann::json object = PlaceJson(obstacle->place_in_world, local_frame);
  object["part"] = obstacle->part == PathPart::kFinal ? "final" : "loiter";
  object["distance_m"] = Rounded(obstacle->distance);
  object["clearance_m"] = Rounded(obstacle->clearance);
  object["required_clearance_m"] = Rounded(obstacle->wanted);
  return object;
}

nlohmann::json GroundRollFeature(const Approach& approach, const LocalFrame& local_frame) {
  const std::vector<Eigen::Vector3d>& corners = approach.ground_roll_in_world;
  // The corners go along the roll, then across it.
  return Feature(PolygonGeometry(corners, local_frame),
                 {{"kind", "ground_roll"},
                  {"length_m", Rounded((corners.at(1) - corners.at(0)).norm())},
                  {"width_m", Rounded((corners.at(2) - corners.at(1)).norm())}});
}

nlohmann::json GoAroundFeature(const Approach& approach, const LocalFrame& local_frame) {
  const GoAround& go_around = *approach.go_around;
  const double height = go_around.start_in_world.z() - approach.touchdown_in_world.z();
  return Feature(LineGeometry({go_around.start_in_world, go_around.end_in_world}, local_frame),
                 {{"kind", "go_around"},
                  {"no_return_distance_m", Rounded(go_around.no_return_distance)},
                  {"height_m", Rounded(height)},
                  {"climb_angle_deg", Rounded(DegFromRad(go_around.climb_angle))},
                  {"unseen_ratio", Rounded(go_around.unseen_ratio)}});
}

std::vector<nlohmann::json> ApproachFeatures(const Approach& approach,
                                             const LocalFrame& local_frame) {
  nlohmann::json final_properties = ApproachProperties(approach, local_frame);
  final_properties["kind"] = "approach";
  const nlohmann::json loiter{{"kind", "loiter"},
                              {"radius_m", Rounded(approach.loiter_radius)},
                              {"direction", DirectionName(approach.loiter_direction)},
                              {"height_m", Rounded(approach.approach_height)},
                              {"unseen_ratio", Rounded(approach.unseen_ratio)}};
  const nlohmann::json touchdown{{"kind", "touchdown"},
                                 {"heading_deg", final_properties["heading_deg"]}};
  std::vector<nlohmann::json> features{
      Feature(LineGeometry({approach.approach_start_in_world, approach.touchdown_in_world},
                           local_frame),
              final_properties),
      Feature(LineGeometry(LoiterPolyline(approach, kNumLoiterLegs), local_frame), loiter),
      Feature(PointGeometry(approach.touchdown_in_world, local_frame), touchdown)};
  if (!approach.ground_roll_in_world.empty()) {
    features.push_back(GroundRollFeature(approach, local_frame));
  }
  if (approach.go_around) features.push_back(GoAroundFeature(approach, local_frame));
  return features;
}

double TrueHeadingDeg(const Approach& approach, const LocalFrame& local_frame) {
  const LocalFrame at_touchdown(local_frame.GeoFromWorld(approach.touchdown_in_world));
  const GeoPoint start = local_frame.GeoFromWorld(approach.approach_start_in_world);
  const Eigen::Vector3d back = at_touchdown.WorldFromGeo(start);
  return DegFromRad(std::atan2(-back.x(), -back.y()));
}

}  // namespace

std::string DirectionName(LoiterDirection direction) {
  return direction == LoiterDirection::kLeft ? "left" : "right";
}

nlohmann::json ApproachProperties(const Approach& approach, const LocalFrame& local_frame) {
  const double heading = TrueHeadingDeg(approach, local_frame);
  nlohmann::json properties{{"heading_deg", Rounded(heading < 0.0 ? heading + 360.0 : heading)},
                            {"distance_m", Rounded(approach.approach_distance)},
                            {"height_m", Rounded(approach.approach_height)},
                            {"crosswind_mps", Rounded(approach.crosswind)},
                            {"loiter_radius_m", Rounded(approach.loiter_radius)},
                            {"loiter_direction", DirectionName(approach.loiter_direction)},
                            {"min_clearance_m", Rounded(approach.min_clearance)}};
  // Obstacle and go-around were searched for if the strip is known.
  if (approach.strip) {
    properties["tightest_obstacle"] = ObstacleJson(approach.obstacle, local_frame);
    properties["no_return_distance_m"] = nullptr;
    if (approach.go_around) {
      properties["no_return_distance_m"] = Rounded(approach.go_around->no_return_distance);
    }
  }
  if (approach.ground_speed) properties["ground_speed_mps"] = Rounded(*approach.ground_speed);
  return properties;
}

nlohmann::json ApproachJson(const Plan& plan, const FlightContext& context) {
  if (!plan.approach) throw ApiError("NoApproach", "the site has no approach");
  nlohmann::json collection =
      FeatureCollection(ApproachFeatures(*plan.approach, context.local_frame));
  collection["profile"] = ProfileJson(*plan.approach, context.local_frame);
  collection["altitude_datum"] = context.altitude_datum;
  // The path alone must show that its site is rejected.
  const nlohmann::json properties = PlanProperties(plan, context);
  for (const char* const name : {"verdict", "reject_reason", "reject_detail"}) {
    if (!properties.contains(name)) continue;
    collection[name] = properties[name];
    for (nlohmann::json& feature : collection["features"]) {
      feature["properties"][name] = properties[name];
    }
  }
  return collection;
}

}  // namespace freelsd
