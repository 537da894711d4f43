#include "api/geojson.h"
#include "api/plan_json.h"

namespace freelsd {
namespace {

// Points and numbers of a planned path; null if no path was planned because of ground or wind.
nlohmann::json PathJson(const Plan& plan, const LocalFrame& local_frame) {
  nlohmann::json path{{"touchdown", nullptr}, {"unseen_ratio", nullptr}};
  if (plan.approach) {
    path["touchdown"] = PlaceJson(plan.touchdown_in_world, local_frame);
    path["unseen_ratio"] = Rounded(plan.approach->unseen_ratio);
  }
  const nlohmann::json properties =
      plan.approach ? ApproachProperties(*plan.approach, local_frame) : nlohmann::json::object();
  for (const char* const name : {"heading_deg", "height_m", "crosswind_mps", "min_clearance_m"}) {
    path[name] = properties.value(name, nlohmann::json(nullptr));
  }
  return path;
}

}  // namespace

nlohmann::json WindRoseJson(const WindRose& rose, const FlightContext& context) {
  nlohmann::json directions_deg = nlohmann::json::array(), entries = nlohmann::json::array();
  for (int i = 0; i < rose.num_directions; ++i) {
    directions_deg.push_back(360.0 * i / rose.num_directions);
  }
  for (size_t speed = 0; speed < rose.speeds.size(); ++speed) {
    for (size_t direction = 0; direction < directions_deg.size(); ++direction) {
      const Plan& plan = rose.At(speed, direction);
      nlohmann::json entry = PathJson(plan, context.local_frame);
      entry["wind_from_deg"] = directions_deg[direction];
      entry["wind_speed_mps"] = rose.speeds[speed];
      entry["verdict"] = NameOf(plan.verdict);
      entry["reject_reason"] =
          plan.reject_reason ? nlohmann::json(NameOf(*plan.reject_reason)) : nullptr;
      entries.push_back(std::move(entry));
    }
  }
  return {{"directions_deg", directions_deg},
          {"speeds_mps", rose.speeds},
          {"altitude_datum", context.altitude_datum},
          {"entries", entries}};
}

}  // namespace freelsd
