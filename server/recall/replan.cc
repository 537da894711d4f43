#include "server/recall/replan.h"

#include <nlohmann/json.hpp>

namespace freelsd {

StoredMapPlanner::StoredMapPlanner(const Replan& replan,
                                   const Aircraft& aircraft,
                                   const SiteMap& site_map)
    : layers(WithLimits(site_map.map,
                        site_map.layers,
                        {aircraft.max_slope_deg, aircraft.max_roughness_m},
                        replan.flight.options.hazard)),
      planner(site_map.map, layers, replan.request, aircraft, replan.flight.options.approach) {}

std::string ReplanJson(const Replan& replan) {
  nlohmann::json footprint = nlohmann::json::array();
  for (const Eigen::Vector2d& corner : replan.request.footprint) {
    footprint.push_back({corner.x(), corner.y()});
  }
  nlohmann::json object{{"flight", replan.flight.canonical_json},
                        {"latitude_deg", replan.origin.latitude_deg},
                        {"longitude_deg", replan.origin.longitude_deg},
                        {"altitude_m", replan.origin.altitude_m},
                        {"footprint_m", footprint},
                        {"area_m2", replan.request.area_m2},
                        {"grade", replan.request.grade},
                        {"num_observations", replan.request.num_observations},
                        {"min_num_observations", replan.request.min_num_observations}};
  if (const auto& wind = replan.request.wind_in_world) {
    object["wind_mps"] = {wind->x(), wind->y()};
    object["wind_spread_mps"] = replan.request.wind_spread_mps;
  }
  return object.dump();
}

Replan ParseReplan(const std::string& text) {
  const nlohmann::json object = nlohmann::json::parse(text);
  Replan replan;
  replan.flight = ParseStoredFlightRequest(object.at("flight"));
  replan.origin = {object.at("latitude_deg"), object.at("longitude_deg"), object.at("altitude_m")};
  for (const nlohmann::json& corner : object.at("footprint_m")) {
    replan.request.footprint.emplace_back(corner.at(0), corner.at(1));
  }
  replan.request.area_m2 = object.at("area_m2");
  replan.request.grade = object.at("grade");
  replan.request.num_observations = object.at("num_observations");
  replan.request.min_num_observations = object.at("min_num_observations");
  if (object.contains("wind_mps")) {
    replan.request.wind_in_world =
        Eigen::Vector2d(object["wind_mps"].at(0), object["wind_mps"].at(1));
    replan.request.wind_spread_mps = object.value("wind_spread_mps", 0.0);
  }
  return replan;
}

}  // namespace freelsd
