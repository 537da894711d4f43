#include "engine/obstacles/obstacles.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include <opencv2/imgproc.hpp>

#include "engine/check/check.h"

namespace freelsd {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

// One straight piece of a line or ring; both ends are the same for a mast.
struct Edge {
  Eigen::Vector3d begin;
  Eigen::Vector3d end;
};

bool IsArea(const HardObstacle& obstacle) { return obstacle.shape == HardObstacle::Shape::kArea; }

std::vector<Edge> EdgesOf(const HardObstacle& obstacle) {
  std::vector<Eigen::Vector3d> points = obstacle.points_in_world;
  if (IsArea(obstacle)) {
    double top = kUnknown;
    for (const Eigen::Vector3d& point : points) top = std::fmax(top, point.z());
    for (Eigen::Vector3d& point : points) point.z() = top;
  }
  if ((IsArea(obstacle) || points.size() == 1) && !points.empty()) points.push_back(points.front());
  std::vector<Edge> edges;
  for (size_t i = 1; i < points.size(); ++i) edges.push_back({points[i - 1], points[i]});
  return edges;
}

Polygon RingOf(const HardObstacle& obstacle) {
  Polygon ring;
  for (const Eigen::Vector3d& point : obstacle.points_in_world) ring.emplace_back(point.head<2>());
  return ring;
}

Eigen::Vector3d NearestOn(const Edge& edge, const Eigen::Vector2d& place) {
  const Eigen::Vector2d way = (edge.end - edge.begin).head<2>();
  const double squared_length = way.squaredNorm();
  if (squared_length == 0.0) return edge.begin;
  const double along =
      std::clamp((place - edge.begin.head<2>()).dot(way) / squared_length, 0.0, 1.0);
  return edge.begin + along * (edge.end - edge.begin);
}

// To the centre of any cell that the obstacle touches.
double ReachOn(const Grid& grid, const HardObstacle& obstacle, const ObstacleOptions& options) {
  return ReachOf(obstacle, options) + grid.cell_size_m * std::sqrt(0.5);
}

// A cell of the obstacle, and the top there, world z; NaN if it is only known above ground.
struct Touched {
  cv::Point cell;
  double top = kUnknown;
};

// Cells of the grid whose centres are within `reach` of the obstacle. A cell may occur twice.
std::vector<Touched> CellsOf(const HardObstacle& obstacle, double reach, const Grid& grid) {
  std::vector<Touched> touched;
  const std::vector<Edge> edges = EdgesOf(obstacle);
  for (const Edge& edge : edges) {
    const Polygon ends{edge.begin.head<2>(), edge.end.head<2>()};
    // One cell more, because CellsAround leaves out cells beyond a grid line.
    const cv::Rect box = grid.CellsAround(ends, reach + grid.cell_size_m);
    for (int row = box.y; row < box.y + box.height; ++row) {
      for (int col = box.x; col < box.x + box.width; ++col) {
        const Eigen::Vector2d place = grid.CellCenter(row, col);
        const Eigen::Vector3d nearest = NearestOn(edge, place);
        if ((nearest.head<2>() - place).norm() > reach) continue;
        touched.push_back({{col, row}, nearest.z()});
      }
    }
  }
  if (!IsArea(obstacle) || edges.empty()) return touched;
  for (const cv::Point& cell : grid.CellsIn(RingOf(obstacle))) {
    touched.push_back({cell, edges.front().begin.z()});
  }
  return touched;
}

// Beside the obstacle, whose cells are within `reach` of it. No distance is above `longest`.
void LimitDistance(const HardObstacle& obstacle,
                   double reach,
                   double longest,
                   HazardLayers& layers) {
  for (const Edge& edge : EdgesOf(obstacle)) {
    const Polygon ends{edge.begin.head<2>(), edge.end.head<2>()};
    const cv::Rect box = layers.grid.CellsAround(ends, reach + longest);
    for (int row = box.y; row < box.y + box.height; ++row) {
      for (int col = box.x; col < box.x + box.width; ++col) {
        const Eigen::Vector2d place = layers.grid.CellCenter(row, col);
        const double beside = (NearestOn(edge, place).head<2>() - place).norm() - reach;
        float& distance = layers.distance(row, col);
        // NaN stays: it is not seen.
        if (distance > beside) distance = static_cast<float>(std::fmax(0.0, beside));
      }
    }
  }
}

// Elevation of each cell, or of the nearest cell that has one; NaN where none has.
cv::Mat1f NearestElevation(const cv::Mat1f& elevation) {
  // OpenCV takes a matrix for equal to itself, NaN included.
  cv::Mat1b is_unknown(elevation.size());
  std::transform(elevation.begin(), elevation.end(), is_unknown.begin(), [](float height) {
    return std::isnan(height) ? uchar{255} : uchar{0};
  });
  const int num_unknown = cv::countNonZero(is_unknown);
  if (num_unknown == 0 || num_unknown == static_cast<int>(elevation.total())) return elevation;
  cv::Mat1f distance;
  cv::Mat1i labels;
  cv::distanceTransform(
      is_unknown, distance, labels, cv::DIST_L2, cv::DIST_MASK_5, cv::DIST_LABEL_PIXEL);
  std::vector<float> by_label(elevation.total() + 1, std::numeric_limits<float>::quiet_NaN());
  const auto at = [&](const cv::Point& cell) -> float& {
    return by_label[static_cast<size_t>(labels(cell))];
  };
  cv::Mat1f nearest(elevation.size());
  for (int pass = 0; pass < 2; ++pass) {
    for (int row = 0; row < elevation.rows; ++row) {
      for (int col = 0; col < elevation.cols; ++col) {
        const cv::Point cell(col, row);
        if (pass == 0 && is_unknown(cell) == 0) at(cell) = elevation(cell);
        if (pass == 1) nearest(cell) = at(cell);
      }
    }
  }
  return nearest;
}

// World z; NaN if neither the top nor the ground is known.
double TopOver(const HardObstacle& obstacle,
               double top,
               double ground,
               const ObstacleOptions& options) {
  return std::fmax(top, ground + obstacle.height_above_ground.value_or(options.min_height_m));
}

// Elevation nearest to a place that may lie beyond the map.
double GroundNear(const Eigen::Vector2d& place, const Grid& grid, const cv::Mat1f& nearest) {
  const Eigen::Vector2d from_corner = (place - grid.north_west_in_world) / grid.cell_size_m;
  const double col = std::clamp(from_corner.x(), 0.0, grid.num_cols - 1.0);
  const double row = std::clamp(-from_corner.y(), 0.0, grid.num_rows - 1.0);
  return nearest(static_cast<int>(row), static_cast<int>(col));
}

// The circle of a plan, widened by all that the obstacle and the aircraft need.
struct Disc {
  Eigen::Vector2d center;
  double radius = 0.0;
  // Tops below it are clear.
  double lowest_top = 0.0;
};

bool IsOnMap(const Disc& disc, const Grid& grid) {
  const Eigen::Vector2d corner = Eigen::Vector2d::Constant(disc.radius);
  return grid.CellAt(disc.center - corner) && grid.CellAt(disc.center + corner);
}

// True if the edge has a place in the disc, off the map and too high.
bool Meets(const Edge& edge,
           const Disc& disc,
           const HardObstacle& obstacle,
           const ElevationMap& map,
           const cv::Mat1f& nearest_elevation,
           const ObstacleOptions& options) {
  constexpr double kStep = 2.0;
  const Eigen::Vector3d way = edge.end - edge.begin;
  const double length = way.head<2>().norm();
  const double from_begin = (disc.center - edge.begin.head<2>()).dot(way.head<2>());
  const double middle = length > 0.0 ? from_begin / length : 0.0;
  // Distances along the edge.
  const double first = std::clamp(middle - disc.radius, 0.0, length);
  const double last = std::clamp(middle + disc.radius, 0.0, length);
  const int num_steps = static_cast<int>(std::ceil((last - first) / kStep));
  for (int i = 0; i <= num_steps; ++i) {
    const double along = num_steps > 0 ? first + (last - first) * i / num_steps : first;
    const Eigen::Vector3d point = length > 0.0 ? edge.begin + along / length * way : edge.begin;
    const Eigen::Vector2d place = point.head<2>();
    if ((place - disc.center).norm() > disc.radius + kStep || map.grid.CellAt(place)) continue;
    const double ground = GroundNear(place, map.grid, nearest_elevation);
    // What is unknown counts as too high.
    if (!(TopOver(obstacle, point.z(), ground, options) < disc.lowest_top)) return true;
  }
  return false;
}

bool MeetsBeyondMap(const Approach& approach,
                    const ElevationMap& map,
                    const Aircraft& aircraft,
                    const HardObstacle& obstacle,
                    const ObstacleOptions& options) {
  const Disc disc{approach.loiter_center_in_world.head<2>(),
                  approach.loiter_radius + aircraft.path_half_width_m + ReachOf(obstacle, options),
                  approach.loiter_center_in_world.z() - aircraft.safety_margin_m};
  const std::vector<Edge> edges = EdgesOf(obstacle);
  const bool is_near = std::any_of(edges.begin(), edges.end(), [&](const Edge& edge) {
    return (NearestOn(edge, disc.center).head<2>() - disc.center).norm() <= disc.radius;
  });
  const bool is_inside = IsArea(obstacle) && Contains(RingOf(obstacle), disc.center);
  if (!is_near && !is_inside) return false;
  const cv::Mat1f nearest_elevation = NearestElevation(map.elevation);
  if (is_inside && !IsOnMap(disc, map.grid)) {
    const double ground = GroundNear(disc.center, map.grid, nearest_elevation);
    const double top = TopOver(obstacle, edges.front().begin.z(), ground, options);
    if (!(top < disc.lowest_top)) return true;
  }
  return std::any_of(edges.begin(), edges.end(), [&](const Edge& edge) {
    return Meets(edge, disc, obstacle, map, nearest_elevation, options);
  });
}

}  // namespace

void ObstacleOptions::Check() const {
  const FieldCheck check("obstacles");
  check.Inside("position_sigma", position_sigma, 0.0, 10.0);
  check.Inside("min_height_m", min_height_m, 1.0, 100.0);
  check.Inside("people_height_m", people_height_m, 1.0, 1000.0);
}

double ReachOf(const HardObstacle& obstacle, const ObstacleOptions& options) {
  return options.position_sigma * obstacle.position_sd_m;
}

AssessedMap WithObstacles(const ElevationMap& map,
                          const HazardLayers& layers,
                          const std::vector<HardObstacle>& obstacles,
                          const ObstacleOptions& options) {
  options.Check();
  if (!(layers.grid == map.grid)) {
    throw std::invalid_argument("obstacles.grid: layers and map are not of the same grid");
  }
  AssessedMap ground{map, layers};
  if (map.elevation.empty()) return ground;
  cv::Mat1f nearest_elevation;
  for (const HardObstacle& obstacle : obstacles) {
    const double reach = ReachOn(map.grid, obstacle, options);
    const std::vector<Touched> touched = CellsOf(obstacle, reach, map.grid);
    if (touched.empty()) continue;
    if (nearest_elevation.empty()) {
      nearest_elevation = NearestElevation(map.elevation);
      ground.map.upper = map.upper.clone();
      ground.layers.grass = layers.grass.clone();
    }
    for (const Touched& each : touched) {
      float& upper = ground.map.upper(each.cell);
      const double top = TopOver(obstacle, each.top, nearest_elevation(each.cell), options);
      upper = std::fmax(upper, static_cast<float>(top));
      ground.layers.grass(each.cell) = 0.0f;
    }
  }
  return ground;
}

HazardLayers WithObstacleHazards(HazardLayers layers,
                                 const std::vector<HardObstacle>& obstacles,
                                 const ObstacleOptions& options) {
  options.Check();
  if (layers.hazard.empty() || obstacles.empty()) return layers;
  layers.hazard = layers.hazard.clone();
  layers.distance = layers.distance.clone();
  double longest = 0.0;
  for (const float distance : layers.distance) longest = std::fmax(longest, distance);
  for (const HardObstacle& obstacle : obstacles) {
    const double reach = ReachOn(layers.grid, obstacle, options);
    for (const Touched& each : CellsOf(obstacle, reach, layers.grid)) {
      uchar& hazard = layers.hazard(each.cell);
      if (hazard == kFree) hazard = kHazard;
      if (!layers.distance.empty()) layers.distance(each.cell) = 0.0f;
    }
    if (longest > 0.0) LimitDistance(obstacle, reach, longest, layers);
  }
  return layers;
}

Plan CheckedBeyondMap(Plan plan,
                      const ElevationMap& map,
                      const Aircraft& aircraft,
                      const std::vector<HardObstacle>& obstacles,
                      const ObstacleOptions& options) {
  if (plan.verdict == Verdict::kRejected || !plan.approach || map.elevation.empty()) return plan;
  for (const HardObstacle& obstacle : obstacles) {
    if (!MeetsBeyondMap(*plan.approach, map, aircraft, obstacle, options)) continue;
    plan.verdict = Verdict::kRejected;
    plan.reject_reason = RejectReason::kLoiterBlocked;
    plan.reject_detail =
        "the loiter circle meets the obstacle " + obstacle.id + " beyond the edge of the map";
    return plan;
  }
  return plan;
}

}  // namespace freelsd
