#include "tests/evaluation/scores/flown_site.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/evaluation/scores/corridor.h"
#include "tests/evaluation/scores/flight_draws.h"

namespace freelsd {
namespace {

// Where no wind was measured: about what a pilot knows of it.
constexpr double kUnmeasuredWindSdMps = 0.5;
// A flight above falling ground is followed this far beyond the disc.
constexpr double kOvershootM = 150.0;

// Everything that is the same for all flights to one site.
struct Target {
  const World& world;
  const TruthMap& truth;
  const Aircraft& aircraft;
  FinalFrame frame;
  // Horizontal, from the start of the final to the touchdown.
  double length = 0.0;
  // Height lost per metre.
  double descent = 0.0;
  double planned_ground_speed = 0.0;
  Corridor with_thin;
  Corridor without_thin;

  const Corridor& CorridorOf(ThinThings thin) const {
    return thin == ThinThings::kCount ? with_thin : without_thin;
  }
};

// One flight: a line to a touchdown at `along`, beside the planned line by `across`.
struct Path {
  double along = 0.0;
  double across = 0.0;
  // World z of the path at its touchdown.
  double height_at_touchdown = 0.0;
  // Whether the aircraft comes down at its touchdown even if the ground there lies lower.
  bool ends_at_touchdown = true;
  double ground_roll = 0.0;
};

struct Outcome {
  // Empty for a landing.
  std::string cause;
  // Place of the contact along the final.
  double along = 0.0;
};

// Ground in doubt counts for nothing: no flight fails by it.
bool IsFree(const TruthMap& truth, const cv::Point& cell, ThinThings thin) {
  if (truth.fault(cell) == static_cast<uint8_t>(GroundFault::kNone)) return true;
  if (NameOfFault(truth, cell) == CoverName(Cover::kDoubt)) return true;
  return thin == ThinThings::kIgnore && IsThinFault(truth, cell);
}

double AirspeedOverGround(const Aircraft& aircraft) {
  return aircraft.landing_airspeed_mps * std::cos(RadFromDeg(aircraft.flight_path_angle_deg));
}

// The nose points into the wind as far as the crosswind needs it.
double GroundSpeedOf(const Target& target, const Eigen::Vector2d& wind) {
  const double airspeed = AirspeedOverGround(target.aircraft);
  const double across = wind.dot(target.frame.Left());
  const double still = std::sqrt(std::max(0.0, airspeed * airspeed - across * across));
  return std::max(0.0, still + wind.dot(target.frame.forward));
}

double GroundRollOf(const Target& target, const Eigen::Vector2d& wind) {
  const double ratio = GroundSpeedOf(target, wind) / target.planned_ground_speed;
  return target.aircraft.ground_roll_m * ratio * ratio;
}

// The highest thing that is met and is no free ground; empty if there is only free ground.
std::string HitAcross(const Target& target,
                      const std::vector<Eigen::Vector2d>& places,
                      double height,
                      ThinThings thin) {
  std::string name;
  double highest = height;
  for (const Eigen::Vector2d& place : places) {
    const double top = TopOf(target.world, place, thin);
    if (top <= highest) continue;
    const cv::Point cell = target.truth.CellAt(place);
    const std::string thing = NameOfThing(target.world, place, thin);
    if (thing != "wire" && IsFree(target.truth, cell, thin)) continue;
    highest = top;
    name = thing == "ground" ? NameOfFault(target.truth, cell) : thing;
  }
  return name;
}

// What the ground roll meets first; empty if it is free. Cells whose centre lies on the strip.
std::string FaultOnRoll(const Target& target, const Path& path, double contact, ThinThings thin) {
  const TruthMap& truth = target.truth;
  const double half_width = target.aircraft.path_half_width_m;
  const double half_cell = 0.5 * truth.cell_size_m;
  const Eigen::Vector2d begin = target.frame.Place(contact, path.across);
  const double reach = path.ground_roll + half_width + truth.cell_size_m;
  const cv::Point low = truth.CellAt(begin - Eigen::Vector2d::Constant(reach));
  const cv::Point high = truth.CellAt(begin + Eigen::Vector2d::Constant(reach));
  std::string fault;
  double first = std::numeric_limits<double>::infinity();
  for (int row = low.y; row <= high.y; ++row) {
    for (int col = low.x; col <= high.x; ++col) {
      const Eigen::Vector2d offset = truth.CellCenter(row, col) - begin;
      const double along = offset.dot(target.frame.forward);
      if (along < -half_cell || along > std::max(path.ground_roll, half_cell)) continue;
      if (std::abs(offset.dot(target.frame.Left())) > half_width) continue;
      if (along >= first || IsFree(truth, {col, row}, thin)) continue;
      first = along;
      fault = NameOfFault(truth, {col, row});
    }
  }
  return fault;
}

Outcome Land(const Target& target, const Path& path, double contact, ThinThings thin) {
  const std::string fault = FaultOnRoll(target, path, contact, thin);
  return {fault.empty() ? "" : "roll: " + fault, contact};
}

Outcome Fly(const Target& target, const Path& path, ThinThings thin) {
  const Corridor& corridor = target.CorridorOf(thin);
  for (int row = corridor.RowAt(path.along - target.length); row < corridor.num_rows(); ++row) {
    const double along = corridor.Along(row);
    if (path.ends_at_touchdown && along >= path.along) return Land(target, path, path.along, thin);
    const double height = path.height_at_touchdown + target.descent * (path.along - along);
    if (corridor.Highest(row, path.across) <= height) continue;
    const std::string hit =
        HitAcross(target, corridor.PlacesAcross(row, path.across), height, thin);
    if (!hit.empty()) return {"final: " + hit, along};
    return Land(target, path, along, thin);
  }
  return {"final: no ground", corridor.Along(corridor.num_rows() - 1)};
}

// Without thin things first: what fails then is no matter of thin things.
struct JudgedFlight {
  Outcome outcome;
  bool is_thin = false;
};

JudgedFlight JudgeFlight(const Target& target, const Path& path) {
  const Outcome solid = Fly(target, path, ThinThings::kIgnore);
  if (!solid.cause.empty()) return {solid, false};
  return {Fly(target, path, ThinThings::kCount), true};
}

Target MakeTarget(const World& world,
                  const TruthMap& truth,
                  const Aircraft& aircraft,
                  const Approach& approach,
                  double height_bias) {
  const Eigen::Vector2d touchdown = approach.touchdown_in_world.head<2>();
  const Eigen::Vector2d to_touchdown = touchdown - approach.approach_start_in_world.head<2>();
  const double length = to_touchdown.norm();
  const double descent =
      (approach.approach_start_in_world.z() - approach.touchdown_in_world.z()) / length;
  const FinalFrame frame{touchdown, to_touchdown / length};
  const double radius = aircraft.touchdown_uncertainty_m;
  const CorridorExtent extent{-length - radius,
                              radius + std::max(0.0, height_bias) / descent + kOvershootM,
                              radius,
                              aircraft.path_half_width_m};
  const double speed = approach.ground_speed.value_or(AirspeedOverGround(aircraft));
  return {world,
          truth,
          aircraft,
          frame,
          length,
          descent,
          speed,
          Corridor(world, frame, extent, ThinThings::kCount),
          Corridor(world, frame, extent, ThinThings::kIgnore)};
}

void CountRelative(FlownSite& flown, const JudgedFlight& flight) {
  ++flown.num_flown;
  if (flight.outcome.cause.empty()) return;
  ++(flight.is_thin ? flown.num_failed_thin : flown.num_failed);
  ++(flight.is_thin ? flown.thin_causes : flown.causes)[flight.outcome.cause];
}

void CountAbsolute(AbsoluteFlights& flights, const JudgedFlight& flight, double disc_radius) {
  if (!flight.outcome.cause.empty()) {
    ++(flight.is_thin ? flights.num_failed_thin : flights.num_failed);
    return;
  }
  flights.landing_place.Add(flight.outcome.along);
  flights.num_short += flight.outcome.along < -disc_radius;
  flights.num_long += flight.outcome.along > disc_radius;
}

}  // namespace

FlownSite FlySite(const World& world,
                  const TruthMap& truth,
                  const Aircraft& aircraft,
                  const Site& site,
                  uint64_t seed) {
  const Approach& approach = site.plan.approach.value();
  const Eigen::Vector3d& touchdown = approach.touchdown_in_world;
  const double floor = world.GroundHeight(touchdown.x(), touchdown.y());
  FlownSite flown;
  flown.height_bias = touchdown.z() - floor;
  const Target target = MakeTarget(world, truth, aircraft, approach, flown.height_bias);
  DrawOptions options;
  options.disc_radius_m = aircraft.touchdown_uncertainty_m;
  options.wind_in_world = world.wind_in_world;
  options.wind_sd_mps = site.wind ? site.wind->spread_mps : kUnmeasuredWindSdMps;
  for (const FlightDraw& draw : DrawFlights(seed, options)) {
    Path path{draw.along, draw.across, floor, true, GroundRollOf(target, draw.wind_in_world)};
    CountRelative(flown, JudgeFlight(target, path));
    path.height_at_touchdown = touchdown.z();
    path.ends_at_touchdown = false;
    CountAbsolute(flown.absolute, JudgeFlight(target, path), aircraft.touchdown_uncertainty_m);
  }
  return flown;
}

}  // namespace freelsd
