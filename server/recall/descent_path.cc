#include "server/recall/descent_path.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include <nlohmann/json.hpp>

#include "api/export/geojson/geojson.h"

namespace freelsd {
namespace {

// About a centimetre.
constexpr double kPlacesPerDegree = 1e7;
constexpr double kStepsPerMetre = 100.0;

double Rounded(double value, double steps) { return std::round(value * steps) / steps; }

// How much of a path's height terrain must leave free.
struct Lowering {
  // Below the path: grows by this each second.
  double per_s = 0.0;
  double clearance_m = 0.0;
  // World z. The path is not lowered below it.
  double least_height_m = -std::numeric_limits<double>::infinity();

  double HeightOf(const DescentPoint& point) const {
    return point.position_in_world.z() - per_s * point.time_s - clearance_m;
  }
};

double LoweringPerSecond(const Descent& shortest, const Glide& worst) {
  const DescentPoint& arrival = shortest.points[shortest.arrival];
  const double lower = std::max(0.0, arrival.position_in_world.z() - worst.arrival_height_m);
  return arrival.time_s > 0.0 ? lower / arrival.time_s : 0.0;
}

DescentPoint Between(const DescentPoint& a, const DescentPoint& b, double ratio) {
  return {a.position_in_world + ratio * (b.position_in_world - a.position_in_world),
          a.time_s + ratio * (b.time_s - a.time_s)};
}

// The lowered path to the circle or to the start of the final, straight between neighbours.
std::vector<Eigen::Vector3d> Lowered(const Descent& descent, const Lowering& lowering) {
  std::vector<Eigen::Vector3d> path;
  const auto add = [&](const DescentPoint& point) {
    path.push_back(point.position_in_world);
    path.back().z() = std::max(lowering.HeightOf(point), lowering.least_height_m);
  };
  for (size_t i = 0; i <= descent.joining; ++i) {
    const DescentPoint& point = descent.points[i];
    const double above = lowering.HeightOf(point) - lowering.least_height_m;
    const double above_before =
        i == 0 ? above : lowering.HeightOf(descent.points[i - 1]) - lowering.least_height_m;
    if (above < 0.0 && above_before > 0.0) {
      add(Between(descent.points[i - 1], point, above_before / (above_before - above)));
    }
    add(point);
  }
  return path;
}

std::vector<Eigen::Vector3d> LoweredShortest(const DescentTask& task,
                                             const std::optional<Descent>& shortest,
                                             double clearance_m) {
  if (shortest) return Lowered(*shortest, {LoweringPerSecond(*shortest, task.worst), clearance_m});
  std::vector<Eigen::Vector3d> line{task.start.position_in_world,
                                    task.plan->approach->approach_start_in_world};
  line.back().z() = task.worst.arrival_height_m;
  for (Eigen::Vector3d& point : line) point.z() -= clearance_m;
  return line;
}

// In the datum of the request.
std::vector<GeoPoint> GeoPath(const std::vector<Eigen::Vector3d>& path, const DescentTask& task) {
  std::vector<GeoPoint> geo_path;
  geo_path.reserve(path.size());
  for (const Eigen::Vector3d& point_in_world : path) {
    geo_path.push_back(task.local_frame.GeoFromWorld(point_in_world));
    geo_path.back().altitude_m += task.subtracted_m;
  }
  return geo_path;
}

// Obstacles on a path to the start of the final, and on the circle and the final.
PathObstacles ObstaclesOn(const std::vector<Eigen::Vector3d>& path,
                          const StoredSites& stored,
                          const EmergencyRequest& request,
                          const DescentTask& task) {
  constexpr int kNumCirclePoints = 24;
  std::vector<Eigen::Vector3d> landing = LoiterPolyline(*task.plan->approach, kNumCirclePoints);
  landing.push_back(task.plan->touchdown_in_world);
  return ObstaclesAlong(
      stored,
      request,
      {GeoPath(path, task), GeoPath(landing, task), task.aircraft.path_half_width_m});
}

// A longer path must meet nothing that the shortest one does not meet.
bool IsClear(const PathObstacles& longer, const PathObstacles& shortest) {
  return (!longer.least || longer.least->margin_m >= 0.0) &&
         longer.of_unknown_top.size() <= shortest.of_unknown_top.size() &&
         longer.airspaces.size() <= shortest.airspaces.size();
}

std::string ListOf(const std::vector<std::string>& ids) {
  std::string list;
  for (const std::string& id : ids) list += (list.empty() ? "" : ", ") + id;
  return list;
}

// Trees that the map may miss are assumed to be lower than the planner's allowance for them.
double MarginBelowStart(const EmergencyRequest& request, const Aircraft& aircraft) {
  return std::min(request.terrain_clearance_m,
                  aircraft.safety_margin_m + ApproachOptions{}.unclear_height_allowance_m);
}

// How far below the start of the final the worst case leads, if its effect shows only after the
// decision to fly the longer path to its end.
double ShortfallM(const Descent& longer, double lowering_per_s, double start_height) {
  const DescentPoint& arrival = longer.points[longer.arrival];
  const double committed_s = arrival.time_s - longer.points[longer.decision].time_s;
  const double above = arrival.position_in_world.z() - start_height;
  return std::max(0.0, lowering_per_s * committed_s - above);
}

// The end of a longer path, with less than the whole clearance, over ground that is all seen.
bool IsEndSeen(const Descent& descent, double full_clearance_height, const KeptTerrain& terrain) {
  for (size_t i = descent.joining; i > 0; --i) {
    const DescentPoint& begin = descent.points[i - 1];
    const DescentPoint& end = descent.points[i];
    if (end.position_in_world.z() >= full_clearance_height) return true;
    const double lost = begin.position_in_world.z() - end.position_in_world.z();
    const double low = full_clearance_height - end.position_in_world.z();
    const double ratio = lost > low ? 1.0 - low / lost : 0.0;
    const Eigen::Vector3d from = Between(begin, end, ratio).position_in_world;
    if (!IsSeenBelow(terrain, from, end.position_in_world)) return false;
  }
  return true;
}

}  // namespace

ToldPath ShortestPath(const StoredSites& stored,
                      const EmergencyRequest& request,
                      const DescentTask& task) {
  ToldPath told;
  told.descent = PlanDescent(task.start, *task.plan->approach, task.aircraft, {});
  const auto path = LoweredShortest(task, told.descent, request.terrain_clearance_m);
  told.terrain = TerrainMarginOf(stored, request, GeoPath(path, task));
  told.obstacles = ObstaclesOn(LoweredShortest(task, told.descent, 0.0), stored, request, task);
  return told;
}

ToldPath PathToTell(const StoredSites& stored,
                    const EmergencyRequest& request,
                    const RecallCandidate& candidate,
                    const DescentTask& task,
                    const ToldPath& shortest) {
  if (shortest.SurplusM() <= GlideOptions{}.max_surplus_m) return shortest;
  const Approach& approach = *task.plan->approach;
  const double start_height = approach.approach_start_in_world.z();
  const double lowering_per_s = LoweringPerSecond(*shortest.descent, task.worst);
  const auto terrain = TerrainBelow(stored, *candidate.row);
  if (!terrain) return shortest;
  ToldPath told = shortest;
  const auto is_safe = [&](const Descent& longer) {
    told.shortfall_m = ShortfallM(longer, lowering_per_s, start_height);
    if (told.shortfall_m > GlideOptions{}.max_shortfall_m) return false;
    const Lowering lowering{
        lowering_per_s,
        request.terrain_clearance_m,
        start_height - told.shortfall_m - MarginBelowStart(request, task.aircraft)};
    const double full_clearance_height = lowering.least_height_m + lowering.clearance_m;
    if (!IsEndSeen(longer, full_clearance_height, *terrain)) return false;
    told.terrain = TerrainMarginOf(stored, request, GeoPath(Lowered(longer, lowering), task));
    if (told.terrain && told.terrain->margin_m < 0.0) return false;
    const Lowering without_clearance{lowering_per_s, 0.0, start_height - told.shortfall_m};
    told.obstacles = ObstaclesOn(Lowered(longer, without_clearance), stored, request, task);
    return IsClear(told.obstacles, shortest.obstacles);
  };
  auto longer = PlanLongerDescent(task.start, approach, task.aircraft, {}, is_safe);
  if (!longer) return shortest;
  told.descent = std::move(longer);
  return told;
}

// Takes the fourth number of each position, its time, and appends it to `times_s`.
void TakeTimes(nlohmann::json& coordinates, nlohmann::json& times_s) {
  for (nlohmann::json& each : coordinates) {
    if (each[0].is_array()) {
      TakeTimes(each, times_s);
    } else {
      times_s.push_back(each[3]);
      each.erase(3);
    }
  }
}

void AddPath(const ToldPath& told, const LocalFrame& local_frame, nlohmann::json& answer) {
  if (!told.descent) return;
  const Descent& descent = *told.descent;
  nlohmann::json coordinates = nlohmann::json::array();
  for (const DescentPoint& point : descent.points) {
    const GeoPoint place = local_frame.GeoFromWorld(point.position_in_world);
    coordinates.push_back({Rounded(place.longitude_deg, kPlacesPerDegree),
                           Rounded(place.latitude_deg, kPlacesPerDegree),
                           Rounded(place.altitude_m, kStepsPerMetre),
                           Rounded(point.time_s, kStepsPerMetre)});
  }
  answer["path"] =
      CutAtAntimeridian({{"type", "LineString"}, {"coordinates", std::move(coordinates)}});
  answer["times_s"] = nlohmann::json::array();
  TakeTimes(answer["path"]["coordinates"], answer["times_s"]);
  if (told.shortfall_m > GlideOptions{}.max_surplus_m) {
    answer["warnings"].push_back(
        "the path loses all surplus height; the uncertainty of the wind may cost up to " +
        std::to_string(std::lround(told.shortfall_m)) +
        " m of it: cut the path short when below its altitudes");
  }
}

namespace {

// " (Restricted area 5)"; empty if no airspace has a name.
std::string NamesOf(const PathObstacles& found) {
  if (found.airspace_names == found.airspaces) return "";
  return " (" + ListOf(found.airspace_names) + ")";
}

}  // namespace

void AddObstacles(const PathObstacles& found, nlohmann::json& answer) {
  answer["wires_known"] = found.are_wires_known;
  if (found.least) {
    answer["obstacle_margin_m"] = found.least->margin_m;
    answer["nearest_obstacle"] = found.least->obstacle_id;
  }
  if (!found.of_unknown_top.empty()) {
    answer["warnings"].push_back("the path crosses " + ListOf(found.of_unknown_top) +
                                 ", of unknown altitude: only the height above ground is known, "
                                 "and no map shows the ground there");
  }
  if (found.airspaces.empty()) return;
  answer["airspaces"] = found.airspaces;
  answer["warnings"].push_back("the path enters the airspace " + ListOf(found.airspaces) +
                               NamesOf(found));
}

}  // namespace freelsd
