#include "engine/approach/landing_strip.h"

#include <algorithm>
#include <cmath>

#include "engine/approach/clearance_surface.h"
#include "engine/approach/corridor.h"

namespace freelsd {
namespace {

// Looks up free ground by distances from touchdown: along the heading and to the right.
class GroundAlong {
 public:
  GroundAlong(const Eigen::Vector2d& touchdown, double heading, const HazardLayers& hazards)
      : hazards_(hazards),
        touchdown_(touchdown),
        forward_(DirectionOf(heading)),
        right_(forward_.y(), -forward_.x()) {}

  // A large field needs hundreds of thousands of lookups: Grid::CellAt takes six times as long.
  bool IsFree(double along, double to_right) const {
    const Grid& grid = hazards_.grid;
    const Eigen::Vector2d place = touchdown_ + along * forward_ + to_right * right_;
    const int col = FloorOf((place.x() - grid.north_west_in_world.x()) / grid.cell_size_m);
    const int row = FloorOf((grid.north_west_in_world.y() - place.y()) / grid.cell_size_m);
    const bool is_inside = row >= 0 && col >= 0 && row < grid.num_rows && col < grid.num_cols;
    return is_inside && hazards_.hazard(row, col) == kFree;
  }
  double step() const { return kAlongSpacing * hazards_.grid.cell_size_m; }

 private:
  const HazardLayers& hazards_;
  Eigen::Vector2d touchdown_, forward_, right_;
};

// Tests 0, step, 2 step, ... Returns the last value before the first one that is not free. Nothing
// if 0 is not free.
template <class Test>
std::optional<double> LastFree(double step, const Test& is_free) {
  int num_free = 0;
  while (is_free(num_free * step)) ++num_free;
  if (num_free == 0) return std::nullopt;
  return (num_free - 1) * step;
}

bool IsSliceFree(const GroundAlong& ground, double along, const Corridor& corridor) {
  for (int i = -corridor.num_each_side; i <= corridor.num_each_side; ++i) {
    if (!ground.IsFree(along, i * corridor.spacing)) return false;
  }
  return true;
}

// Tests a line beside the strip at these distances ahead of the touchdown.
bool IsLineFree(const GroundAlong& ground, double to_right, const std::vector<double>& distances) {
  return std::all_of(distances.begin(), distances.end(), [&](double along) {
    return ground.IsFree(along, to_right);
  });
}

}  // namespace

// A cell reaches into the rectangle if its centre is at most half a diagonal away. Samples reach
// farther than the rectangle by that much.
LandingStrip MeasureStrip(const Eigen::Vector3d& touchdown_in_world,
                          double heading,
                          const HazardLayers& hazards,
                          const Aircraft& aircraft) {
  const double cell_size = hazards.grid.cell_size_m, margin = cell_size * std::sqrt(0.5);
  const GroundAlong ground(touchdown_in_world.head<2>(), heading, hazards);
  const Corridor corridor = MakeCorridor(heading, aircraft.path_half_width_m, cell_size);
  const auto run = [&](double sign) {
    return LastFree(ground.step(),
                    [&](double along) { return IsSliceFree(ground, sign * along, corridor); });
  };
  const std::optional<double> ahead = run(1.0), behind = run(-1.0);
  if (!ahead || !behind || std::min(*ahead, *behind) < margin) return {};
  const std::vector<double> distances = Steps(-*behind, *ahead, ground.step());
  const auto beside = [&](double sign) {
    const double reach = corridor.Reach();
    const std::optional<double> wider = LastFree(ground.step(), [&](double beyond) {
      return IsLineFree(ground, sign * (reach + beyond), distances);
    });
    return reach + wider.value_or(0.0) - margin;
  };
  return {.ahead = *ahead - margin,
          .behind = *behind - margin,
          .left = beside(-1.0),
          .right = beside(1.0)};
}

std::vector<Eigen::Vector3d> GroundRollCorners(const Eigen::Vector3d& touchdown_in_world,
                                               double heading,
                                               const Aircraft& aircraft) {
  if (aircraft.ground_roll_m <= 0.0) return {};
  const Eigen::Vector2d forward = DirectionOf(heading);
  const Eigen::Vector2d along = aircraft.ground_roll_m * forward;
  const Eigen::Vector2d right =
      aircraft.path_half_width_m * Eigen::Vector2d(forward.y(), -forward.x());
  std::vector<Eigen::Vector3d> corners;
  for (const Eigen::Vector2d& corner : {Eigen::Vector2d(right),
                                        Eigen::Vector2d(right + along),
                                        Eigen::Vector2d(along - right),
                                        Eigen::Vector2d(-right)}) {
    corners.emplace_back(touchdown_in_world.x() + corner.x(),
                         touchdown_in_world.y() + corner.y(),
                         touchdown_in_world.z());
  }
  return corners;
}

}  // namespace freelsd
