#include "server/recall/descent_path.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <nlohmann/json.hpp>

namespace freelsd {
namespace {

// Surplus height that needs no warning.
constexpr double kMinSurplusM = 2.0;
// About a centimetre.
constexpr double kPlacesPerDegree = 1e7;
constexpr double kStepsPerMetre = 100.0;

double Rounded(double value, double steps) { return std::round(value * steps) / steps; }

}  // namespace

void AddDescent(const Descent& descent, const LocalFrame& local_frame, nlohmann::json& answer) {
  nlohmann::json coordinates = nlohmann::json::array();
  nlohmann::json times_s = nlohmann::json::array();
  for (const DescentPoint& point : descent.points) {
    const GeoPoint place = local_frame.GeoFromWorld(point.position_in_world);
    coordinates.push_back({Rounded(place.longitude_deg, kPlacesPerDegree),
                           Rounded(place.latitude_deg, kPlacesPerDegree),
                           Rounded(place.altitude_m, kStepsPerMetre)});
    times_s.push_back(Rounded(point.time_s, kStepsPerMetre));
  }
  answer["path"] = {{"type", "LineString"}, {"coordinates", std::move(coordinates)}};
  answer["times_s"] = std::move(times_s);
  if (descent.surplus_height_m > kMinSurplusM) {
    answer["warnings"].push_back(std::to_string(std::lround(descent.surplus_height_m)) +
                                 " m of surplus height are left at the start of the final, too "
                                 "little for a circle: lose them on the final");
  }
}

std::vector<GeoPoint> UncheckedPath(const Descent& descent,
                                    const Glide& worst,
                                    const LocalFrame& local_frame) {
  const DescentPoint& arrival = descent.points[descent.arrival];
  const double lower = std::max(0.0, arrival.position_in_world.z() - worst.arrival_height_m);
  std::vector<GeoPoint> path;
  for (size_t i = 0; i <= descent.arrival; ++i) {
    Eigen::Vector3d position_in_world = descent.points[i].position_in_world;
    if (arrival.time_s > 0.0) {
      position_in_world.z() -= lower * descent.points[i].time_s / arrival.time_s;
    }
    path.push_back(local_frame.GeoFromWorld(position_in_world));
  }
  return path;
}

}  // namespace freelsd
