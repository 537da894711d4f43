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

// What all winds share, and for each height of the start, in order, what its paths can reach.
struct Ground {
  FootprintContent content;
  TouchdownCandidates candidates;
  std::optional<Refusal> refusal;
  std::vector<Aircraft> aircraft;
  std::vector<ClearanceSurface> surfaces;
};

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
  for (const double ratio : options.start_height_ratios) {
    const Aircraft higher = WithStartHeight(aircraft, ratio);
    std::vector<WindScenario> scenarios;
    for (const double speed : speeds) {
      scenarios.push_back({ApproachDistance(higher, speed), LoiterRadius(higher, speed)});
    }
    ground.surfaces.push_back(
        MakeClearanceSurface(map, hazards, request.footprint, scenarios, higher, options));
    ground.aircraft.push_back(higher);
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
  const WindCase lowest_wind = AgainstWind(towards, speed, aircraft);
  std::optional<Refusal> refusal = ground.refusal;
  if (!refusal) refusal = RefuseWind(lowest_wind);
  if (refusal) {
    return RefusedEntry(ground, request, refusal->reason, lowest_wind.headings.front());
  }
  std::optional<WindRoseEntry> lowest;
  for (size_t i = 0; i < ground.surfaces.size(); ++i) {
    const WindCase wind = AgainstWind(towards, speed, ground.aircraft[i]);
    const auto cells = MakeHeadingCells(wind, ground.surfaces[i], ground.aircraft[i], options);
    const AttemptContext context{ground.surfaces[i], wind, ground.aircraft[i], options, cells};
    const Touchdown touchdown = SearchTouchdown(ground.candidates, context).best.touchdown;
    const WindRoseEntry entry =
        EntryOf(Try(touchdown, 0, context, Depth::kEverything), ground.aircraft[i]);
    if (entry.verdict != Verdict::kRejected) return entry;
    if (!lowest) lowest = entry;
    if (lowest->reject_reason != RejectReason::kLoiterBlocked) break;
  }
  return *lowest;
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

WindRoseEntry LessSafe(const WindRoseEntry& a, const WindRoseEntry& b) {
  WindRoseEntry entry = IsSafer(a, b) ? b : a;
  const bool is_one_path =
      a.touchdown_in_world == b.touchdown_in_world && a.approach_height == b.approach_height;
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
      least_safe = least_safe ? LessSafe(*least_safe, entry) : entry;
    }
  }
  return least_safe;
}

}  // namespace freelsd
