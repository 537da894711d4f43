#include "tests/evaluation/recorded/control_points.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <set>
#include <sstream>
#include <stdexcept>

#include <Eigen/Geometry>
#include <GeographicLib/Geocentric.hpp>
#include <GeographicLib/TransverseMercator.hpp>

#include "engine/geometry/triangulation.h"

namespace freelsd {
namespace {

constexpr int kMinNumTargets = 5;

std::vector<std::vector<std::string>> ReadTable(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error("cannot read " + path);
  std::vector<std::vector<std::string>> rows;
  std::string line;
  std::getline(file, line);
  while (std::getline(file, line)) {
    std::vector<std::string> cells;
    std::istringstream stream(line);
    for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
    if (cells.size() < 4) throw std::runtime_error(path + ": a line of fewer than four values");
    rows.push_back(cells);
  }
  return rows;
}

// Columns: the same target in the world of the block, and where it was surveyed.
struct Correspondences {
  std::vector<std::string> names;
  Eigen::Matrix3Xd in_world;
  Eigen::Matrix3Xd in_grid;
};

Correspondences TriangulateTargets(const AdjustedBlock& block,
                                   const Targets& targets,
                                   const std::vector<TargetSighting>& sightings) {
  Correspondences result;
  for (const auto& [name, point_in_world] : PlacesOfTargets(block, sightings)) {
    const Eigen::Index i = result.in_world.cols();
    result.in_world.conservativeResize(3, i + 1);
    result.in_grid.conservativeResize(3, i + 1);
    result.in_world.col(i) = point_in_world;
    result.in_grid.col(i) = targets.at(name);
    result.names.push_back(name);
  }
  return result;
}

Eigen::Matrix4d Similarity(const Eigen::Matrix3Xd& from, const Eigen::Matrix3Xd& to) {
  // Eastings of hundreds of kilometres would cost digits.
  const Eigen::Vector3d origin = to.col(0);
  Eigen::Matrix4d transform = Eigen::umeyama(from, (to.colwise() - origin).eval(), true);
  transform.topRightCorner<3, 1>() += origin;
  return transform;
}

Eigen::Matrix3Xd Without(const Eigen::Matrix3Xd& points, Eigen::Index left_out) {
  Eigen::Matrix3Xd rest(3, points.cols() - 1);
  rest << points.leftCols(left_out), points.rightCols(points.cols() - left_out - 1);
  return rest;
}

// Columns: how far each target is off under the similarity of the others.
Eigen::Matrix3Xd LeaveOneOutErrors(const Correspondences& points) {
  Eigen::Matrix3Xd errors(3, points.in_world.cols());
  for (Eigen::Index i = 0; i < errors.cols(); ++i) {
    const Eigen::Matrix4d transform =
        Similarity(Without(points.in_world, i), Without(points.in_grid, i));
    errors.col(i) =
        (transform * points.in_world.col(i).homogeneous()).head<3>() - points.in_grid.col(i);
  }
  return errors;
}

double HorizontalRms(const Eigen::Matrix3Xd& errors) {
  return std::sqrt(errors.topRows<2>().squaredNorm() / static_cast<double>(errors.cols()));
}

double VerticalRms(const Eigen::Matrix3Xd& errors) {
  return std::sqrt(errors.row(2).squaredNorm() / static_cast<double>(errors.cols()));
}

constexpr double kBeyondDeviations = 3.0;

void CheckHeight(const ElevationMap& map,
                 const Eigen::Matrix4d& grid_from_world,
                 const Eigen::Vector3d& target,
                 HeightChecks* checks) {
  ++checks->num_targets;
  const Eigen::Vector3d in_world = (grid_from_world.inverse() * target.homogeneous()).head<3>();
  const auto cell = map.grid.CellAt(in_world.head<2>());
  if (!cell || std::isnan(map.elevation(*cell))) return;
  const double error = std::abs(map.elevation(*cell) - in_world.z());
  const double former = checks->num_known > 0 ? checks->rms_m : 0.0;
  const double sum = former * former * checks->num_known + error * error;
  ++checks->num_known;
  checks->rms_m = std::sqrt(sum / checks->num_known);
  checks->largest_m = std::fmax(checks->largest_m, error);
  checks->num_beyond += error > kBeyondDeviations * map.standard_deviation(*cell);
}

// Those that a view of the largest group shows.
std::set<std::string> SightedTargets(const AdjustedBlock& block,
                                     const std::vector<TargetSighting>& sightings) {
  std::set<std::string> frame_ids, targets;
  for (const size_t i : block.LargestGroup()) frame_ids.insert(block.views[i].frame_id);
  for (const TargetSighting& sighting : sightings) {
    if (frame_ids.contains(sighting.frame_id)) targets.insert(sighting.target);
  }
  return targets;
}

void CheckMap(const ElevationMap& map,
              const Correspondences& points,
              const Targets& targets,
              const std::set<std::string>& sighted,
              ControlErrors* errors) {
  const Eigen::Matrix4d of_all = Similarity(points.in_world, points.in_grid);
  for (const auto& [name, target] : targets) {
    CheckHeight(map, of_all, target, &errors->map);
    const auto twice = std::find(points.names.begin(), points.names.end(), name);
    if (twice != points.names.end()) {
      const Eigen::Index i = twice - points.names.begin();
      const Eigen::Matrix4d of_others =
          Similarity(Without(points.in_world, i), Without(points.in_grid, i));
      CheckHeight(map, of_others, target, &errors->map_seen_twice);
    } else if (sighted.contains(name)) {
      CheckHeight(map, of_all, target, &errors->map_seen_once);
    }
  }
}

}  // namespace

Targets ReadTargets(const std::string& path) {
  Targets targets;
  for (const auto& row : ReadTable(path)) {
    targets[row[0]] = {std::stod(row[1]), std::stod(row[2]), std::stod(row[3])};
  }
  return targets;
}

std::vector<TargetSighting> ReadSightings(const std::string& path) {
  std::vector<TargetSighting> sightings;
  for (const auto& row : ReadTable(path)) {
    sightings.push_back({row[0], row[1], {std::stod(row[2]), std::stod(row[3])}});
  }
  return sightings;
}

std::map<std::string, Eigen::Vector3d> PlacesOfTargets(
    const AdjustedBlock& block, const std::vector<TargetSighting>& sightings) {
  std::map<std::string, std::vector<PosedRay>> rays;
  for (const TargetSighting& sighting : sightings) {
    for (const size_t i : block.LargestGroup()) {
      const AdjustedView& view = block.views[i];
      if (view.frame_id != sighting.frame_id) continue;
      rays[sighting.target].push_back(
          {view.world_from_camera, block.CameraOf(i).NormalizedFromImage(sighting.point_in_image)});
    }
  }
  std::map<std::string, Eigen::Vector3d> places;
  for (const auto& [name, rays_of_target] : rays) {
    const auto point = Triangulate(rays_of_target);
    if (point) places[name] = point->point_in_world;
  }
  return places;
}

GeoPoint GeoFromBritishGrid(const Eigen::Vector3d& target) {
  constexpr double kAiryRadiusM = 6377563.396, kAiryFlattening = 1.0 / 299.3249646;
  constexpr double kScale = 0.9996012717, kOriginLatitudeDeg = 49.0, kOriginLongitudeDeg = -2.0;
  const GeographicLib::TransverseMercator projection(kAiryRadiusM, kAiryFlattening, kScale);
  double ignored, northing_of_origin;
  projection.Forward(
      kOriginLongitudeDeg, kOriginLatitudeDeg, kOriginLongitudeDeg, ignored, northing_of_origin);
  double latitude_deg, longitude_deg;
  projection.Reverse(kOriginLongitudeDeg,
                     target.x() - 400000.0,
                     target.y() + 100000.0 + northing_of_origin,
                     latitude_deg,
                     longitude_deg);
  Eigen::Vector3d airy;
  GeographicLib::Geocentric(kAiryRadiusM, kAiryFlattening)
      .Forward(latitude_deg, longitude_deg, target.z(), airy.x(), airy.y(), airy.z());
  // OSGB36 to WGS84: metres, seconds of arc, parts per million.
  const Eigen::Vector3d translation(446.448, -125.157, 542.060);
  const Eigen::Vector3d turn = Eigen::Vector3d(0.1502, 0.2470, 0.8421) * (kPi / 180.0 / 3600.0);
  constexpr double kScaleError = -20.4894e-6;
  const Eigen::Vector3d wgs84 = translation + (1.0 + kScaleError) * airy + turn.cross(airy);
  GeoPoint point;
  double height_above_ellipsoid;
  GeographicLib::Geocentric::WGS84().Reverse(wgs84.x(),
                                             wgs84.y(),
                                             wgs84.z(),
                                             point.latitude_deg,
                                             point.longitude_deg,
                                             height_above_ellipsoid);
  point.altitude_m = target.z();
  return point;
}

ControlErrors CompareWithTargets(const RecordedFlight& flight,
                                 const ElevationMap& map,
                                 const Targets& targets,
                                 const std::vector<TargetSighting>& sightings) {
  const Correspondences points = TriangulateTargets(flight.block, targets, sightings);
  ControlErrors errors;
  errors.num_targets = static_cast<int>(points.names.size());
  if (errors.num_targets < kMinNumTargets) return errors;
  const Eigen::Matrix3Xd aligned = LeaveOneOutErrors(points);
  errors.aligned_horizontal_m = HorizontalRms(aligned);
  errors.aligned_vertical_m = VerticalRms(aligned);
  errors.largest_horizontal_m = aligned.topRows<2>().colwise().norm().maxCoeff();
  errors.largest_vertical_m = aligned.row(2).cwiseAbs().maxCoeff();
  Eigen::Matrix3Xd georeferenced = points.in_world;
  for (Eigen::Index i = 0; i < georeferenced.cols(); ++i) {
    georeferenced.col(i) -= flight.frame.WorldFromGeo(GeoFromBritishGrid(points.in_grid.col(i)));
  }
  errors.shift_in_world = georeferenced.rowwise().mean();
  georeferenced.colwise() -= errors.shift_in_world;
  errors.georeferenced_horizontal_m = HorizontalRms(georeferenced);
  errors.georeferenced_vertical_m = VerticalRms(georeferenced);
  CheckMap(map, points, targets, SightedTargets(flight.block, sightings), &errors);
  return errors;
}

}  // namespace freelsd
