#include "engine/glide/reach_fan.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "engine/glide/glide.h"

namespace freelsd {
namespace {

// One straight line of the fan.
struct Ray {
  // Columns and rows; step per metre in the frame of the air.
  Eigen::Vector2d begin = Eigen::Vector2d::Zero();
  Eigen::Vector2d step = Eigen::Vector2d::Zero();
  // At its begin.
  double height = 0.0;
  // Metres in the frame of the air.
  double length = 0.0;

  Eigen::Vector2d At(double length_m) const { return begin + length_m * step; }
};

// The lines that begin with turns in one sense: 1 is right, -1 is left.
class Turns {
 public:
  Turns(const FanTask& task, const Grid& grid, double sense)
      : task_(task), grid_(grid), sense_(sense) {}

  Ray RayAfter(double turn) const {
    const Performance& performance = task_.performance;
    const double radius = performance.turn_radius;
    const double time = turn * radius / performance.Airspeed();
    const Eigen::Vector2d aside =
        sense_ * radius * (1.0 - std::cos(turn)) * DirectionOf(task_.heading + 0.5 * kPi);
    const Eigen::Vector2d along = radius * std::sin(turn) * DirectionOf(task_.heading);
    const Eigen::Vector2d begin =
        task_.position_in_world.head<2>() + aside + along + time * task_.wind;
    const Eigen::Vector2d step =
        DirectionOf(task_.heading + sense_ * turn) + task_.wind / performance.Airspeed();
    Ray ray;
    ray.begin = Eigen::Vector2d(begin.x() - grid_.north_west_in_world.x(),
                                grid_.north_west_in_world.y() - begin.y()) /
                grid_.cell_size_m;
    ray.step = Eigen::Vector2d(step.x(), -step.y()) / grid_.cell_size_m;
    ray.height = task_.position_in_world.z() - time * performance.turning_sink_rate;
    ray.length = std::min(task_.max_straight_m, LengthAfter(turn));
    return ray;
  }

 private:
  // To where turning the other way is shorter: the line of the heading behind the aircraft, in the
  // frame of the air. Near the aircraft: through the circle on the other side, wherever the wind
  // drifts it during a whole turn.
  double LengthAfter(double turn) const {
    if (turn <= kPi) return std::numeric_limits<double>::infinity();
    const double radius = task_.performance.turn_radius;
    const double sine = std::min(std::sin(turn), -1e-9);
    const double to_heading_line = radius * (1.0 - std::cos(turn)) / -sine;
    const double drift = task_.wind.norm() / task_.performance.Airspeed() * 4.0 * kPi * radius;
    const double overlap = task_.overlap_m + drift;
    if (turn < 1.5 * kPi) return to_heading_line + overlap;
    const double chord = std::cos(turn) * (1.0 - std::cos(turn));
    const double out_of_circle =
        radius * (-2.0 * std::sin(turn) + 2.0 * std::sqrt(std::max(0.0, chord)));
    return std::max(to_heading_line, out_of_circle) + overlap;
  }

  const FanTask& task_;
  const Grid& grid_;
  double sense_;
};

struct Sector {
  Ray first;
  Ray last;
  ClearWay clear;
};

// Both rays are flown down to the lower one's heights.
Sector SectorBetween(const Ray& first,
                     const Ray& last,
                     const FanTask& task,
                     const HeightPyramid& pyramid,
                     const ReachLimits& limits) {
  const StraightGlide& straight = task.performance.straight;
  SlopingLine middle;
  middle.begin = 0.5 * (first.begin + last.begin);
  middle.step_per_metre = 0.5 * (first.step + last.step);
  middle.height = last.height;
  middle.loss_per_metre = straight.sink_rate_mps / straight.airspeed_mps;
  middle.length = std::max(first.length, last.length);
  return {first,
          last,
          pyramid.ClearWayAlong(middle,
                                limits.terrain_clearance_m,
                                std::max(limits.terrain_clearance_m, limits.arrival_height_m))};
}

// The part of a sector between two lengths of its rays.
FanPolygon Between(const Sector& sector, double begin, double end) {
  const Ray& first = sector.first;
  const Ray& last = sector.last;
  return {first.At(std::min(begin, first.length)),
          first.At(std::min(end, first.length)),
          last.At(std::min(end, last.length)),
          last.At(std::min(begin, last.length))};
}

// Parts between the places of a sector that are too high to arrive there.
void AddParts(const Sector& sector, Fan& fan) {
  double begin = 0.0;
  for (const auto& [low_begin, low_end] : sector.clear.low) {
    if (low_begin > begin) fan.polygons.push_back(Between(sector, begin, low_begin));
    begin = low_end;
  }
  if (sector.clear.length > begin) {
    fan.polygons.push_back(Between(sector, begin, sector.clear.length));
  }
}

// One polygon for neighbouring sectors: along their ends, and back along the turn. Its winding
// number is the sum of theirs, so a place around which it winds lies in at least one of them.
FanPolygon Strip(const std::vector<Sector>& sectors) {
  FanPolygon polygon;
  polygon.reserve(3 * sectors.size() + 1);
  for (const Sector& sector : sectors) {
    polygon.push_back(sector.first.At(std::min(sector.first.length, sector.clear.length)));
    polygon.push_back(sector.last.At(std::min(sector.last.length, sector.clear.length)));
  }
  polygon.push_back(sectors.back().last.begin);
  for (auto sector = sectors.rbegin(); sector != sectors.rend(); ++sector) {
    polygon.push_back(sector->first.begin);
  }
  return polygon;
}

// Gathers sectors in the order of their turns.
class FanBuilder {
 public:
  explicit FanBuilder(size_t max_num_in_strip) : max_num_in_strip_(max_num_in_strip) {}

  void Add(Sector sector) {
    fan_.num_steps += sector.clear.num_steps;
    if (!sector.clear.low.empty()) {
      Flush();
      AddParts(sector, fan_);
      return;
    }
    strip_.push_back(std::move(sector));
    if (strip_.size() >= max_num_in_strip_) Flush();
  }
  void Flush() {
    if (!strip_.empty()) fan_.polygons.push_back(Strip(strip_));
    strip_.clear();
  }
  const Fan& fan() const { return fan_; }

 private:
  size_t max_num_in_strip_;
  std::vector<Sector> strip_;
  Fan fan_;
};

}  // namespace

Fan FanOf(const FanTask& task,
          const Grid& grid,
          const HeightPyramid& pyramid,
          const ReachLimits& limits) {
  // Short strips, so that few sectors of a strip overlap.
  constexpr int kNumStrips = 16;
  FanBuilder builder(static_cast<size_t>(task.num_sectors / kNumStrips + 1));
  const double step = 2.0 * kPi / task.num_sectors;
  for (const double sense : {1.0, -1.0}) {
    const Turns turns(task, grid, sense);
    Ray first = turns.RayAfter(0.0);
    for (int i = 0; i < task.num_sectors; ++i) {
      const Ray last = turns.RayAfter((i + 1) * step);
      // The turn itself must be clear too.
      if (!pyramid.IsClear(last.begin, last.height, limits.terrain_clearance_m)) break;
      builder.Add(SectorBetween(first, last, task, pyramid, limits));
      first = last;
    }
    builder.Flush();
  }
  return builder.fan();
}

}  // namespace freelsd
