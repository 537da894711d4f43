#include "engine/glide/glide.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "engine/check/check.h"
#include "engine/glide/performance.h"
#include "engine/glide/transit.h"

namespace freelsd {
namespace {

// Least difference between line and upper surface within the grid, sampled every half cell.
std::optional<double> LeastAt(const Grid& grid,
                              const cv::Mat1f& upper,
                              const Eigen::Vector3d& begin,
                              const Eigen::Vector3d& end,
                              int num_steps) {
  // Column, row and height.
  const auto in_cells = [&grid](const Eigen::Vector3d& point) {
    return Eigen::Vector3d((point.x() - grid.north_west_in_world.x()) / grid.cell_size_m,
                           (grid.north_west_in_world.y() - point.y()) / grid.cell_size_m,
                           point.z());
  };
  const Eigen::Vector3d first = in_cells(begin);
  const Eigen::Vector3d line = in_cells(end) - first;
  std::optional<double> least;
  for (int i = 0; i <= num_steps; ++i) {
    const Eigen::Vector3d point = first + line * (static_cast<double>(i) / num_steps);
    const bool is_inside = point.x() >= 0.0 && point.y() >= 0.0 && point.x() < grid.num_cols &&
                           point.y() < grid.num_rows;
    if (!is_inside) continue;
    const double top =
        static_cast<double>(upper(static_cast<int>(point.y()), static_cast<int>(point.x())));
    if (!std::isfinite(top)) continue;
    const double height = point.z() - top;
    if (!least || height < *least) least = height;
  }
  return least;
}

}  // namespace

void GlideOptions::Check() const {
  const FieldCheck check("glide");
  check.Inside("unknown_wind_mps", unknown_wind_mps, 0.0, 50.0);
  check.Inside("num_unknown_winds", num_unknown_winds, 4, 360);
  check.Inside("num_wind_deviations", num_wind_deviations, 0.0, 5.0);
  check.Inside("num_unknown_headings", num_unknown_headings, 8, 360);
  check.Inside("terrain_clearance_m", terrain_clearance_m, 0.0, 1000.0);
  check.Inside("datum_penalty_m", datum_penalty_m, 0.0, 1000.0);
  check.Inside("max_surplus_m", max_surplus_m, 0.0, 100.0);
  check.Inside("max_shortfall_m", max_shortfall_m, 0.0, 100.0);
}

Aircraft Unpowered(Aircraft aircraft, std::optional<double> glide_ratio) {
  if (glide_ratio) aircraft.glide_ratio = *glide_ratio;
  aircraft.Check();
  const double glide_angle_deg = DegFromRad(std::atan(1.0 / aircraft.glide_ratio));
  aircraft.flight_path_angle_deg = std::max(aircraft.flight_path_angle_deg, glide_angle_deg);
  return aircraft;
}

std::optional<Glide> GlideTo(const GlideStart& start,
                             const Eigen::Vector3d& approach_start_in_world,
                             double final_heading,
                             const Aircraft& aircraft,
                             const GlideOptions& options) {
  const Performance performance = PerformanceOf(aircraft);
  const double extra_time = TimeBetweenHeadings(start, performance, options);
  Glide worst;
  for (const Eigen::Vector2d& wind : WindsToReckonWith(start, aircraft, options)) {
    for (const double heading : HeadingsToReckonWith(start, options)) {
      const TransitTask task = TransitTaskOf(start.position_in_world.head<2>(),
                                             heading,
                                             approach_start_in_world.head<2>(),
                                             final_heading,
                                             wind,
                                             performance);
      std::optional<Transit> transit = TightestTransit(task, performance);
      if (!transit) transit = LongestTransit(task, performance);
      if (!transit) return std::nullopt;
      worst.time_s = std::max(worst.time_s, transit->time + extra_time);
      worst.height_lost_m = std::max(
          worst.height_lost_m, transit->height_lost + extra_time * performance.turning_sink_rate);
    }
  }
  worst.arrival_height_m = start.position_in_world.z() - worst.height_lost_m;
  return worst;
}

std::optional<double> LeastHeightLost(const GlideStart& start,
                                      const Eigen::Vector2d& place_in_world,
                                      double within_m,
                                      const StraightGlide& glide) {
  const Eigen::Vector2d way = place_in_world - start.position_in_world.head<2>();
  const double length = way.norm();
  const double distance = length - within_m;
  if (distance <= 0.0) return 0.0;
  // In wind the nearest point of a disc may not be the quickest. The wind adds at most its speed.
  const double wind_speed = start.wind_in_world ? start.wind_in_world->norm() : 0.0;
  const double along = start.wind_in_world ? start.wind_in_world->dot(way) / length : 0.0;
  const double turned_aside = std::min(1.0, within_m / length);
  const double speed = glide.airspeed_mps + along + wind_speed * turned_aside;
  if (speed <= 0.0) return std::nullopt;
  return distance / speed * glide.sink_rate_mps;
}

std::optional<double> LeastHeightOver(const Grid& grid,
                                      const cv::Mat1f& upper,
                                      const Eigen::Vector3d& begin_in_world,
                                      const Eigen::Vector3d& end_in_world) {
  if (grid.num_rows == 0 || grid.num_cols == 0) return std::nullopt;
  const Eigen::Vector2d way = (end_in_world - begin_in_world).head<2>();
  // Only the part of the line near the grid is sampled.
  const Eigen::Vector2d size(grid.num_cols * grid.cell_size_m, grid.num_rows * grid.cell_size_m);
  const Eigen::Vector2d center =
      grid.north_west_in_world + 0.5 * Eigen::Vector2d(size.x(), -size.y());
  const double length = way.norm();
  const double reach = 0.5 * size.norm();
  const double middle = length > 0.0 ? (center - begin_in_world.head<2>()).dot(way) / length : 0.0;
  const double first = length > 0.0 ? std::clamp((middle - reach) / length, 0.0, 1.0) : 0.0;
  const double last = length > 0.0 ? std::clamp((middle + reach) / length, 0.0, 1.0) : 1.0;
  const Eigen::Vector3d line = end_in_world - begin_in_world;
  const int num_steps =
      std::max(1, static_cast<int>(std::ceil((last - first) * length / (0.5 * grid.cell_size_m))));
  return LeastAt(
      grid, upper, begin_in_world + first * line, begin_in_world + last * line, num_steps);
}

}  // namespace freelsd
