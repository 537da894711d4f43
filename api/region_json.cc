#include "api/geojson.h"

namespace freelsd {

nlohmann::json RegionFeature(const Region& region,
                             const std::optional<WindEstimate>& wind,
                             const FlightContext& context) {
  const nlohmann::json properties{{"id", region.id},
                                  {"flight_id", context.flight_id},
                                  {"grade", NumberOrNull(region.grade)},
                                  {"num_observations", region.num_observations},
                                  {"num_grass_observations", region.num_grass_observations},
                                  {"area_m2", Rounded(region.area_m2)},
                                  {"is_fixed", region.is_fixed},
                                  {"wind", WindJson(wind)},
                                  {"first_seen_frame_id", region.first_seen_frame_id},
                                  {"last_seen_frame_id", region.last_seen_frame_id},
                                  {"last_seen_us", region.last_seen_us}};
  nlohmann::json feature =
      Feature(PolygonGeometry(region.corners_in_world, context.local_frame), properties);
  feature["id"] = region.id;
  return feature;
}

nlohmann::json RegionHistoryJson(const Region& region) {
  nlohmann::json history = nlohmann::json::array();
  for (const RegionHistory& entry : region.history) {
    nlohmann::json grass_ratio = nullptr;
    if (entry.num_observations > 0) {
      grass_ratio =
          Rounded(static_cast<double>(entry.num_grass_observations) / entry.num_observations);
    }
    history.push_back({{"frame_id", entry.frame_id},
                       {"timestamp_us", entry.timestamp_us},
                       {"num_observations", entry.num_observations},
                       {"num_grass_observations", entry.num_grass_observations},
                       {"grass_ratio", grass_ratio},
                       {"grade", NumberOrNull(entry.grade)},
                       {"area_m2", Rounded(entry.area_m2)}});
  }
  return {{"region_id", region.id}, {"history", std::move(history)}};
}

}  // namespace freelsd
