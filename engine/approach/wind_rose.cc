#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <tuple>

#include "engine/approach/approach.h"
#include "engine/approach/refusal.h"
#include "engine/approach/search.h"

namespace freelsd {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr int kMaxNumDirections = 3600;
constexpr size_t kMaxNumSpeeds = 1000;
// A wind this near to one of the table (share of the step) is that one.
constexpr double kSameWind = 1e-9;

void Require(bool holds, const std::string& message) {
  if (!holds) throw std::invalid_argument("wind_rose." + message);
}

// What all winds share.
struct Ground {
  FootprintContent content;
  TouchdownCandidates candidates;
  std::optional<Refusal> refusal;
  // What paths from each height of the start can reach.
  std::vector<ClearanceSurface> surfaces;
};

const Eigen::Vector2d kAnyDirection(0.0, 1.0);

Ground PrepareGround(const ElevationMap& map,
                     const HazardLayers& hazards,
                     const PlanRequest& request,
                     const Aircraft& aircraft,
                     const ApproachOptions& options,
                     const std::vector<double>& speeds) {
  Ground ground;
  const double required = RequiredHazardDistance(map, aircraft, options);
  ground.content = ReadFootprint(map, hazards, request.footprint, options);
  ground.refusal = RefuseGround(request, ground.content, required, aircraft);
  if (ground.refusal) return ground;
  ground.candidates =
      SelectCandidates(ground.content.touchdowns, required, map.grid.cell_size_m, options);
  std::vector<std::vector<WindScenario>> scenarios(options.start_height_ratios.size());
  std::vector<Aircraft> from_height(scenarios.size());
  for (const double speed : speeds) {
    for (const Way& way : WaysAgainst(kAnyDirection, speed, aircraft, options)) {
      const std::vector<WindScenario> more = way.Scenarios();
      scenarios[way.start_height].insert(
          scenarios[way.start_height].end(), more.begin(), more.end());
      from_height[way.start_height] = way.aircraft;
    }
  }
  for (size_t i = 0; i < scenarios.size(); ++i) {
    ground.surfaces.push_back(MakeClearanceSurface(
        map, hazards, request.footprint, scenarios[i], from_height[i], options));
  }
  return ground;
}

WindRoseEntry RefusedEntry(const Ground& ground,
                           const PlanRequest& request,
                           RejectReason reason,
                           double heading) {
  WindRoseEntry entry;
  entry.reject_reason = reason;
  entry.heading = heading;
  entry.min_clearance = entry.clearance_ratio = entry.unseen_ratio = kNaN;
  if (!ground.content.touchdowns.empty()) {
    entry.touchdown_in_world = ground.content.touchdowns.front().place_in_world;
    entry.hazard_distance = ground.content.touchdowns.front().hazard_distance;
  } else if (!request.footprint.empty()) {
    entry.touchdown_in_world << Centroid(request.footprint), request.ground_height;
  }
  return entry;
}

double FiniteOrNaN(double value) { return std::isfinite(value) ? value : kNaN; }

WindRoseEntry EntryOf(const Attempt& attempt, const Aircraft& aircraft) {
  WindRoseEntry entry;
  entry.approach_height = aircraft.approach_height_m;
  entry.verdict = attempt.verdict;
  entry.reject_reason = attempt.reason;
  entry.touchdown_in_world = attempt.touchdown.place_in_world;
  entry.heading = attempt.heading;
  entry.loiter_direction = attempt.direction;
  entry.hazard_distance = attempt.touchdown.hazard_distance;
  entry.min_clearance =
      FiniteOrNaN(std::min(attempt.final_path.min_clearance, attempt.circle.min_clearance));
  entry.clearance_ratio = FiniteOrNaN(
      std::min(attempt.final_path.min_clearance_ratio, attempt.circle.min_clearance_ratio));
  entry.unseen_ratio = attempt.circle.UnseenRatio();
  return entry;
}

WindRoseEntry PlanWind(const Ground& ground,
                       const Eigen::Vector2d& towards,
                       double speed,
                       const PlanRequest& request,
                       const Aircraft& aircraft,
                       const ApproachOptions& options) {
  std::optional<WindRoseEntry> first;
  bool is_loiter_blocked = false;
  for (const Way& way : WaysAgainst(towards, speed, aircraft, options)) {
    if (way.start_height > 0 && !is_loiter_blocked) break;
    std::optional<Refusal> refusal = ground.refusal;
    if (!refusal) refusal = RefuseWind(way.wind);
    if (refusal) {
      return RefusedEntry(ground, request, refusal->reason, way.wind.headings.front().heading);
    }
    const ClearanceSurface& surface = ground.surfaces[way.start_height];
    const auto cells = MakeHeadingCells(way.wind, surface, way.aircraft, options);
    const AttemptContext context{surface, way.wind, way.aircraft, options, cells};
    const Attempt best = SearchTouchdown(ground.candidates, context).best;
    const WindRoseEntry entry =
        EntryOf(Try(best.touchdown, best.heading_index, context, Depth::kEverything), way.aircraft);
    if (entry.verdict != Verdict::kRejected) return entry;
    is_loiter_blocked |= entry.reject_reason == RejectReason::kLoiterBlocked;
    if (!first) first = entry;
  }
  return *first;
}

// Places in a row of the table that enclose a value, and how far between them it lies.
std::vector<size_t> Enclosing(double place, size_t count) {
  const auto lower = static_cast<size_t>(place + kSameWind);
  if (std::abs(place - static_cast<double>(lower)) <= kSameWind) return {lower % count};
  return {lower % count, (lower + 1) % count};
}

// Nothing beyond the table.
std::vector<size_t> EnclosingSpeeds(const std::vector<double>& speeds, double speed) {
  for (size_t i = 0; i < speeds.size(); ++i) {
    if (std::abs(speeds[i] - speed) <= kSameWind * (1.0 + speed)) return {i};
  }
  const auto above = std::lower_bound(speeds.begin(), speeds.end(), speed);
  if (above == speeds.begin() || above == speeds.end()) return {};
  const auto index = static_cast<size_t>(above - speeds.begin());
  return {index - 1, index};
}

// NaN is the least.
double Least(double a, double b) { return std::isnan(a) || std::isnan(b) ? kNaN : std::min(a, b); }

bool IsSafer(const WindRoseEntry& a, const WindRoseEntry& b) {
  const auto key = [](const WindRoseEntry& entry) {
    const double ratio = entry.clearance_ratio;
    return std::tuple(entry.verdict,
                      std::isnan(entry.unseen_ratio) ? 1.0 : entry.unseen_ratio,
                      std::isnan(ratio) ? std::numeric_limits<double>::infinity() : -ratio);
  };
  return key(a) < key(b);
}

// Of one path, turned by no more than `max_turn`.
WindRoseEntry LessSafe(const WindRoseEntry& a, const WindRoseEntry& b, double max_turn) {
  WindRoseEntry entry = IsSafer(a, b) ? b : a;
  const bool is_one_path = a.touchdown_in_world == b.touchdown_in_world &&
                           a.approach_height == b.approach_height &&
                           std::abs(WrapAngle(a.heading - b.heading)) <= max_turn + kSameWind;
  if (!is_one_path) entry.verdict = std::max(entry.verdict, Verdict::kUnverified);
  entry.hazard_distance = std::min(a.hazard_distance, b.hazard_distance);
  entry.min_clearance = Least(a.min_clearance, b.min_clearance);
  entry.clearance_ratio = Least(a.clearance_ratio, b.clearance_ratio);
  entry.unseen_ratio = -Least(-a.unseen_ratio, -b.unseen_ratio);
  return entry;
}

}  // namespace

void WindRoseOptions::Check() const {
  Require(num_directions >= 1 && num_directions <= kMaxNumDirections,
          "num_directions = " + std::to_string(num_directions) + ": must be in [1, " +
              std::to_string(kMaxNumDirections) + "]");
  Require(!speeds_mps.empty() && speeds_mps.size() <= kMaxNumSpeeds,
          "speeds_mps = " + std::to_string(speeds_mps.size()) + " numbers: must be 1 to " +
              std::to_string(kMaxNumSpeeds));
  double last = -1.0;
  for (const double speed : speeds_mps) {
    Require(std::isfinite(speed) && speed >= 0.0 && speed > last,
            "speeds_mps = " + std::to_string(speed) + ": must be >= 0 and ascending");
    last = speed;
  }
}

const WindRoseEntry& WindRose::At(size_t speed, size_t direction) const {
  return entries.at(speed * static_cast<size_t>(num_directions) + direction);
}

WindRose PlanWindRose(const ElevationMap& map,
                      const HazardLayers& hazards,
                      const PlanRequest& request,
                      const Aircraft& profile,
                      const ApproachOptions& options,
                      const WindRoseOptions& rose_options) {
  rose_options.Check();
  RequireOneGrid(map, hazards);
  const Aircraft aircraft = WithPositionMargin(profile, map, options);
  WindRose rose{rose_options.num_directions, rose_options.speeds_mps, options.calm_wind_mps, {}};
  const Ground ground =
      PrepareGround(map, hazards, request, aircraft, options, rose_options.speeds_mps);
  for (const double speed : rose.speeds) {
    for (int i = 0; i < rose.num_directions; ++i) {
      const Eigen::Vector2d towards = DirectionOf(2.0 * kPi * i / rose.num_directions);
      rose.entries.push_back(PlanWind(ground, towards, speed, request, aircraft, options));
    }
  }
  return rose;
}

std::optional<WindRoseEntry> LookUp(const WindRose& rose, const Eigen::Vector2d& wind_in_world) {
  if (!wind_in_world.allFinite() || rose.entries.empty()) return std::nullopt;
  const double speed = wind_in_world.norm();
  const auto num_directions = static_cast<size_t>(rose.num_directions);
  if (speed < rose.calm_wind && rose.speeds.front() == 0.0) {
    const auto end = rose.entries.begin() + rose.num_directions;
    return *std::min_element(rose.entries.begin(), end, IsSafer);
  }
  double turn = HeadingOf(wind_in_world) / (2.0 * kPi);
  turn -= std::floor(turn);
  std::optional<WindRoseEntry> least_safe;
  for (const size_t row : EnclosingSpeeds(rose.speeds, speed)) {
    for (const size_t direction : Enclosing(turn * rose.num_directions, num_directions)) {
      const WindRoseEntry& entry = rose.At(row, direction);
      least_safe =
          least_safe ? LessSafe(*least_safe, entry, 2.0 * kPi / rose.num_directions) : entry;
    }
  }
  return least_safe;
}

}  // namespace freelsd
