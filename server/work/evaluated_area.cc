#include "server/work/evaluated_area.h"

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

namespace freelsd {

std::string AreaJson(const std::vector<Candidate>& regions, const LocalFrame& local_frame) {
  using AlignedBox = Eigen::AlignedBox2d;
  AlignedBox box;
  for (const Candidate& candidate : regions) {
    for (const Eigen::Vector2d& corner : candidate.region.Footprint()) box.extend(corner);
  }
  if (box.isEmpty()) return {};
  nlohmann::json ring = nlohmann::json::array();
  for (const AlignedBox::CornerType type : {AlignedBox::BottomLeft,
                                            AlignedBox::BottomRight,
                                            AlignedBox::TopRight,
                                            AlignedBox::TopLeft,
                                            AlignedBox::BottomLeft}) {
    const Eigen::Vector2d corner = box.corner(type);
    const GeoPoint place = local_frame.GeoFromWorld({corner.x(), corner.y(), 0.0});
    ring.push_back({place.longitude_deg, place.latitude_deg});
  }
  return nlohmann::json{{"type", "Polygon"}, {"coordinates", nlohmann::json::array({ring})}}.dump();
}

}  // namespace freelsd
