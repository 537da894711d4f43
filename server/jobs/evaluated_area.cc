#include "server/jobs/evaluated_area.h"

#include <nlohmann/json.hpp>

#include "api/export/geojson/geojson.h"

namespace freelsd {

std::string AreaJson(const Box& area, const LocalFrame& local_frame) {
  if (area.IsEmpty()) return {};
  nlohmann::json ring = nlohmann::json::array();
  for (const Eigen::Vector2d& corner : {area.min,
                                        Eigen::Vector2d(area.max.x(), area.min.y()),
                                        area.max,
                                        Eigen::Vector2d(area.min.x(), area.max.y()),
                                        area.min}) {
    const GeoPoint place = local_frame.GeoFromWorld({corner.x(), corner.y(), 0.0});
    ring.push_back({place.longitude_deg, place.latitude_deg});
  }
  return CutAtAntimeridian({{"type", "Polygon"}, {"coordinates", nlohmann::json::array({ring})}})
      .dump();
}

}  // namespace freelsd
