#include "tests/synthetic/truth.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <opencv2/imgproc.hpp>

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

// The ground roll goes on into the wind from touchdown.
bool IsRollFree(const World& world,
                const cv::Mat1f& free_distance,
                const Aircraft& aircraft,
                const Eigen::Vector2d& touchdown) {
  const double cell = world.size_m / free_distance.rows;
  for (double s = 0.0; s <= aircraft.ground_roll_m; s += 0.5 * cell) {
    const Eigen::Vector2d place = touchdown - s * Downwind(world);
    const int col = static_cast<int>(std::floor((place.x() + 0.5 * world.size_m) / cell));
    const int row = static_cast<int>(std::floor((place.y() + 0.5 * world.size_m) / cell));
    if (col < 0 || row < 0 || col >= free_distance.cols || row >= free_distance.rows) return false;
    if (free_distance(row, col) <= 0.0f) return false;
  }
  return true;
}

struct TouchdownCandidate {
  Eigen::Vector2d place = Eigen::Vector2d::Zero();
  double free_radius = 0.0;
};

// Cells of a parcel with room for the touchdown disc, widest first.
std::vector<TouchdownCandidate> Candidates(const World& world,
                                           const Parcel& parcel,
                                           const cv::Mat1f& free_distance,
                                           double min_radius) {
  const double cell = world.size_m / free_distance.rows;
  std::vector<TouchdownCandidate> candidates;
  for (int row = 0; row < free_distance.rows; ++row) {
    for (int col = 0; col < free_distance.cols; ++col) {
      const double radius = free_distance(row, col) * cell;
      if (radius < min_radius) continue;
      const Eigen::Vector2d place((col + 0.5) * cell - 0.5 * world.size_m,
                                  (row + 0.5) * cell - 0.5 * world.size_m);
      if (Contains(parcel.outline, place)) candidates.push_back({place, radius});
    }
  }
  std::stable_sort(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) {
    return a.free_radius > b.free_radius;
  });
  return candidates;
}

TrueField JudgeField(const World& world,
                     const Aircraft& aircraft,
                     const Parcel& parcel,
                     const cv::Mat1f& free_distance) {
  TrueField field;
  field.parcel = parcel;
  const std::vector<TouchdownCandidate> candidates =
      Candidates(world, parcel, free_distance, aircraft.touchdown_uncertainty_m);
  field.reason = candidates.empty() ? "no room for the touchdown disc" : "no final is clear";
  for (const TouchdownCandidate& candidate : candidates) {
    if (!IsRollFree(world, free_distance, aircraft, candidate.place)) continue;
    if (FinalReserve(world, aircraft, candidate.place) < 0.0) continue;
    field.is_landable = true;
    field.touchdown = candidate.place;
    field.free_radius = candidate.free_radius;
    field.reason.clear();
    break;
  }
  return field;
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

cv::Mat1b LandableGround(const World& world, const Aircraft& aircraft, double cell_size_m) {
  const int n = static_cast<int>(std::floor(world.size_m / cell_size_m));
  cv::Mat1b landable(n, n, static_cast<uint8_t>(0));
  cv::parallel_for_({0, n}, [&](const cv::Range& rows) {
    for (int row = rows.start; row < rows.end; ++row) {
      for (int col = 0; col < n; ++col) {
        const double x = (col + 0.5) * cell_size_m - 0.5 * world.size_m;
        const double y = (row + 0.5) * cell_size_m - 0.5 * world.size_m;
        const GroundFault fault = GroundFaultAt(world, aircraft, x, y, cell_size_m);
        landable(row, col) = fault == GroundFault::kNone ? 255 : 0;
      }
    }
  });
  return landable;
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

std::vector<TrueField> JudgeFields(const World& world, const Aircraft& aircraft) {
  const cv::Mat1b landable = LandableGround(world, aircraft);
  cv::Mat1f free_distance;
  cv::distanceTransform(landable, free_distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  std::vector<TrueField> fields;
  for (const Parcel& parcel : world.parcels) {
    if (parcel.cover != Cover::kMeadow) continue;
    fields.push_back(JudgeField(world, aircraft, parcel, free_distance));
  }
  return fields;
}

}  // namespace freelsd
