#include "tests/synthetic/truth.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace freelsd {
namespace {

constexpr double kGravity = 9.81;
// Slope is that of the ground over this distance, roughness that of single cells.
constexpr double kSlopeSupportM = 9.0;
constexpr double kPathStepM = 0.5;
// Below this the wind has no direction; the final then runs east.
constexpr double kCalmMps = 1e-3;

Eigen::Vector2d Downwind(const World& world) {
  const double speed = world.wind_in_world.norm();
  if (speed < kCalmMps) return -Eigen::Vector2d::UnitX();
  return world.wind_in_world / speed;
}

double CircleRadius(const World& world, const Aircraft& aircraft) {
  const double glide = RadFromDeg(aircraft.flight_path_angle_deg);
  const double speed = aircraft.landing_airspeed_mps * std::cos(glide) + world.wind_in_world.norm();
  return speed * speed / (kGravity * std::tan(RadFromDeg(aircraft.max_bank_deg)));
}

// Highest thing within the corridor's half-width of a point of a path.
double HighestAcross(const World& world,
                     const Eigen::Vector2d& point,
                     const Eigen::Vector2d& across,
                     double half_width) {
  double highest = -std::numeric_limits<double>::infinity();
  for (double s = -half_width; s <= half_width + 1e-9; s += kPathStepM) {
    const Eigen::Vector2d place = point + s * across;
    highest = std::max({highest,
                        world.SurfaceHeight(place.x(), place.y()),
                        world.TopHeight(place.x(), place.y())});
  }
  return highest;
}

bool IsEven(const World& world, const Aircraft& aircraft, double x, double y) {
  const double half = 0.5 * kSlopeSupportM;
  const double dx =
      (world.GroundHeight(x + half, y) - world.GroundHeight(x - half, y)) / kSlopeSupportM;
  const double dy =
      (world.GroundHeight(x, y + half) - world.GroundHeight(x, y - half)) / kSlopeSupportM;
  return std::atan(std::hypot(dx, dy)) <= RadFromDeg(aircraft.max_slope_deg);
}

// Of all that stands in a square cell.
double MeanSurface(const World& world, double x, double y, double cell) {
  const cv::Range rows = world.CellsAround(y, 0.5 * cell), cols = world.CellsAround(x, 0.5 * cell);
  double sum = 0.0;
  for (int row = rows.start; row < rows.end; ++row) {
    for (int col = cols.start; col < cols.end; ++col) sum += world.surface(row, col);
  }
  return sum / (rows.size() * cols.size());
}

// Ruggedness over the eight neighbours (Riley et al. 1999), which is one of cells: of single points
// one stalk each would make a lawn rugged.
bool IsSmooth(const World& world, const Aircraft& aircraft, double x, double y, double cell) {
  const double middle = MeanSurface(world, x, y, cell);
  double sum = 0.0;
  for (int i = -1; i <= 1; ++i) {
    for (int j = -1; j <= 1; ++j) {
      const double step = MeanSurface(world, x + i * cell, y + j * cell, cell) - middle;
      sum += step * step;
    }
  }
  return std::sqrt(sum) <= aircraft.max_roughness_m;
}

bool IsMeadowOnly(const World& world, double x, double y, double cell) {
  const cv::Range rows = world.CellsAround(y, 0.5 * cell), cols = world.CellsAround(x, 0.5 * cell);
  for (int row = rows.start; row < rows.end; ++row) {
    for (int col = cols.start; col < cols.end; ++col) {
      if (static_cast<Cover>(world.cover(row, col)) != Cover::kMeadow) return false;
    }
  }
  return true;
}

}  // namespace

// Eq. 1 of the paper.
double TrueFinalLength(const World& world, const Aircraft& aircraft) {
  const double glide = RadFromDeg(aircraft.flight_path_angle_deg);
  const double head =
      world.wind_in_world.norm() * std::cos(RadFromDeg(aircraft.crosswind_uncertainty_deg));
  return (aircraft.landing_airspeed_mps * std::cos(glide) - head) /
         (aircraft.landing_airspeed_mps * std::sin(glide)) * aircraft.approach_height_m;
}

GroundFault GroundFaultAt(
    const World& world, const Aircraft& aircraft, double x, double y, double cell_size_m) {
  const double edge = 0.5 * world.size_m - cell_size_m;
  if (std::max(std::abs(x), std::abs(y)) > edge) return GroundFault::kOutside;
  if (!IsMeadowOnly(world, x, y, cell_size_m)) return GroundFault::kCover;
  if (!IsEven(world, aircraft, x, y)) return GroundFault::kSteep;
  if (!IsSmooth(world, aircraft, x, y, cell_size_m)) return GroundFault::kRough;
  return GroundFault::kNone;
}

double FinalReserve(const World& world,
                    const Aircraft& aircraft,
                    const Eigen::Vector2d& touchdown) {
  const double length = TrueFinalLength(world, aircraft);
  if (length <= 0.0) return -std::numeric_limits<double>::infinity();
  const Eigen::Vector2d downwind = Downwind(world);
  const Eigen::Vector2d across(-downwind.y(), downwind.x());
  const double floor = world.GroundHeight(touchdown.x(), touchdown.y());
  double reserve = std::numeric_limits<double>::infinity();
  for (double s = aircraft.touchdown_uncertainty_m; s <= length; s += kPathStepM) {
    const double above = aircraft.approach_height_m * s / length;
    const double wanted = std::min(aircraft.safety_margin_m, 0.5 * above);
    const double highest =
        HighestAcross(world, touchdown + s * downwind, across, aircraft.path_half_width_m);
    reserve = std::min(reserve, floor + above - highest - wanted);
  }
  return reserve;
}

double LoiterReserve(const World& world,
                     const Aircraft& aircraft,
                     const Eigen::Vector2d& touchdown,
                     int side) {
  const double radius = CircleRadius(world, aircraft);
  const Eigen::Vector2d downwind = Downwind(world);
  // Left of the heading, which is upwind.
  const Eigen::Vector2d left(downwind.y(), -downwind.x());
  const Eigen::Vector2d center =
      touchdown + TrueFinalLength(world, aircraft) * downwind + side * radius * left;
  const double height =
      world.GroundHeight(touchdown.x(), touchdown.y()) + aircraft.approach_height_m;
  double reserve = std::numeric_limits<double>::infinity();
  const double step = kPathStepM / radius;
  for (double angle = 0.0; angle < 2.0 * kPi; angle += step) {
    const Eigen::Vector2d outward(std::cos(angle), std::sin(angle));
    const double highest =
        HighestAcross(world, center + radius * outward, outward, aircraft.path_half_width_m);
    reserve = std::min(reserve, height - highest - aircraft.safety_margin_m);
  }
  return reserve;
}

}  // namespace freelsd
