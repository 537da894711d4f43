#include "engine/approach/approach_geometry.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace freelsd {
namespace {

constexpr double kGravity = 9.81;  // m/s^2, as in the paper's numbers
constexpr int kMinPolylinePoints = 4;

// Along the path, in still air.
double GroundSpeed(const Aircraft& aircraft) {
  return aircraft.landing_airspeed_mps * std::cos(RadFromDeg(aircraft.flight_path_angle_deg));
}

double SinkRate(const Aircraft& aircraft) {
  return aircraft.landing_airspeed_mps * std::sin(RadFromDeg(aircraft.flight_path_angle_deg));
}

// `scenarios_of` gives the winds for a heading.
template <class ScenariosOf>
std::vector<HeadingCase> AllHeadings(double step_deg, const ScenariosOf& scenarios_of) {
  std::vector<HeadingCase> headings;
  for (int i = 0; i * step_deg < 360.0; ++i) {
    const double heading = RadFromDeg(i * step_deg);
    headings.push_back({heading, scenarios_of(heading)});
  }
  return headings;
}

double FinalLength(const Aircraft& aircraft, double headwind) {
  return (GroundSpeed(aircraft) - headwind) / SinkRate(aircraft) * aircraft.approach_height_m;
}

// The headwind that Eq. 1 assumes, with the wind at this angle to the heading.
double SureHeadwind(const Aircraft& aircraft, double wind_speed, double off_deg) {
  constexpr double kBehindDeg = 180.0;
  const double turned_deg = std::min(kBehindDeg, aircraft.crosswind_uncertainty_deg + off_deg);
  return wind_speed * std::cos(RadFromDeg(turned_deg));
}

// Ground speed on final, with the wind at this angle to the heading. The nose points into the wind
// as far as the crosswind needs it.
double GroundSpeedAgainst(const Aircraft& aircraft, double wind_speed, double off_deg) {
  const double across = wind_speed * std::sin(RadFromDeg(off_deg));
  const double against = wind_speed * std::cos(RadFromDeg(off_deg));
  const double airspeed = GroundSpeed(aircraft);
  return std::sqrt(std::max(0.0, airspeed * airspeed - across * across)) - against;
}

// Heading straight into the wind, at any wind speed.
WindCase AgainstWind(const Eigen::Vector2d& wind_in_world,
                     const Aircraft& aircraft,
                     double wind_margin) {
  const double wind_speed = wind_in_world.norm();
  WindCase wind;
  wind.is_known = true;
  wind.wind_speed = wind_speed + wind_margin;
  wind.ground_speed = GroundSpeedAgainst(aircraft, wind.wind_speed, 0.0);
  const WindScenario scenario{ApproachDistance(aircraft, wind_speed, wind_margin),
                              LoiterRadius(aircraft, wind.wind_speed),
                              0.0,
                              GroundSpeedAgainst(aircraft, wind_speed, 0.0)};
  wind.headings = {{HeadingOf(-wind_in_world), {scenario}}};  // downwind start, into the wind
  // The length of the final assumes only a part of the wind, so it does not show whether the
  // aircraft makes headway.
  wind.is_too_strong =
      scenario.approach_distance <= 0.0 || wind.ground_speed < aircraft.min_ground_speed_mps;
  return wind;
}

// Headings off the wind, up to the aircraft's crosswind limit. None if the wind is too weak to
// matter, or too strong to make headway.
WindCase AcrossWind(const Eigen::Vector2d& wind_in_world,
                    const Aircraft& aircraft,
                    const ApproachOptions& options,
                    double wind_margin) {
  constexpr double kAbeamDeg = 90.0;
  const double wind_speed = wind_in_world.norm();
  WindCase wind = AgainstWind(wind_in_world, aircraft, wind_margin);
  const double into_wind = wind.headings.front().heading;
  wind.headings.clear();
  if (wind_speed < options.calm_wind_mps || wind.is_too_strong) return wind;
  const double most = options.max_crosswind_ratio * aircraft.landing_airspeed_mps;
  for (int i = 1; i * options.heading_step_deg < kAbeamDeg; ++i) {
    const double off_deg = i * options.heading_step_deg;
    const double headwind = SureHeadwind(aircraft, wind_speed, off_deg) - wind_margin;
    const WindScenario scenario{FinalLength(aircraft, headwind),
                                LoiterRadius(aircraft, wind.wind_speed),
                                wind_speed * std::sin(RadFromDeg(off_deg)),
                                GroundSpeedAgainst(aircraft, wind_speed, off_deg)};
    if (scenario.crosswind + wind_margin > most) break;
    for (const double side : {-1.0, 1.0}) {
      wind.headings.push_back({into_wind + side * RadFromDeg(off_deg), {scenario}});
    }
  }
  return wind;
}

// Unsigned, 0 to 180.
double DegreesBetween(double heading, double other) {
  return std::abs(DegFromRad(std::remainder(heading - other, 2.0 * kPi)));
}

// Case of a wind that is too weak to determine the heading. The circle is computed for the wind as
// in Eq. 1. The final is longer if the wind blows from behind. It is not shorter in a headwind,
// because so weak a wind may turn at any time.
WindCase InCalm(const Eigen::Vector2d& wind_in_world,
                const Aircraft& aircraft,
                const ApproachOptions& options,
                double wind_margin) {
  const double wind_speed = wind_in_world.norm();
  const double into_wind = HeadingOf(-wind_in_world);
  WindCase wind;
  wind.is_known = true;
  wind.wind_speed = wind_speed + wind_margin;
  wind.ground_speed = GroundSpeedAgainst(aircraft, wind.wind_speed, 0.0);
  wind.is_too_strong = wind.ground_speed < aircraft.min_ground_speed_mps;
  wind.headings = AllHeadings(options.heading_step_deg, [&](double heading) {
    const double off_deg = DegreesBetween(heading, into_wind);
    const double headwind = std::min(0.0, SureHeadwind(aircraft, wind_speed, off_deg));
    return std::vector<WindScenario>{{FinalLength(aircraft, headwind - wind_margin),
                                      LoiterRadius(aircraft, wind.wind_speed),
                                      0.0,
                                      GroundSpeedAgainst(aircraft, wind_speed, off_deg)}};
  });
  return wind;
}

Aircraft WithStartHeight(Aircraft aircraft, double ratio) {
  aircraft.approach_height_m *= ratio;
  return aircraft;
}

// Calls `cases` for each start height, in order. Leaves out results without a heading.
template <class Cases>
std::vector<Way> FromEachHeight(const Aircraft& aircraft,
                                const ApproachOptions& options,
                                const Cases& cases) {
  std::vector<Way> ways;
  for (size_t i = 0; i < options.start_height_ratios.size(); ++i) {
    const Aircraft higher = WithStartHeight(aircraft, options.start_height_ratios[i]);
    for (WindCase& wind : cases(higher)) {
      if (!wind.headings.empty()) ways.push_back({i, higher, std::move(wind)});
    }
  }
  return ways;
}

// From the aircraft to the circle's centre, at a right angle to the heading.
Eigen::Vector2d TowardsCenter(double heading, LoiterDirection direction) {
  const Eigen::Vector2d forward = DirectionOf(heading);
  const Eigen::Vector2d left(-forward.y(), forward.x());
  return direction == LoiterDirection::kLeft ? left : Eigen::Vector2d(-left);
}

// Corridor, ground roll and position margin beside and behind the path.
constexpr double kReachMarginM = 60.0;
// Near winds then need the same part of a map.
constexpr double kReachStepM = 100.0;

}  // namespace

double ApproachDistance(const Aircraft& aircraft, double wind_speed, double wind_margin) {
  return FinalLength(aircraft, SureHeadwind(aircraft, wind_speed, 0.0) - wind_margin);
}

double DownwindApproachDistance(const Aircraft& aircraft, double wind_speed) {
  return (GroundSpeed(aircraft) + wind_speed) / SinkRate(aircraft) * aircraft.approach_height_m;
}

double LoiterRadius(const Aircraft& aircraft, double wind_speed) {
  const double speed = GroundSpeed(aircraft) + wind_speed;  // Eq. 1
  return speed * speed / (kGravity * std::tan(RadFromDeg(aircraft.max_bank_deg)));
}

WindCase MakeWindCase(const std::optional<Eigen::Vector2d>& wind_in_world,
                      const Aircraft& aircraft,
                      const ApproachOptions& options,
                      double wind_margin) {
  if (!wind_in_world) {
    const double worst = options.unknown_wind_mps;
    std::vector<WindScenario> scenarios{
        {ApproachDistance(aircraft, 0.0), LoiterRadius(aircraft, 0.0)},
        {DownwindApproachDistance(aircraft, worst), LoiterRadius(aircraft, worst)}};
    WindCase wind;
    wind.headings = AllHeadings(options.heading_step_deg, [&](double) { return scenarios; });
    return wind;
  }
  if (!wind_in_world->allFinite() || !std::isfinite(wind_margin)) {
    throw std::invalid_argument("approach.wind_in_world: must be finite");
  }
  if (wind_in_world->norm() < options.calm_wind_mps) {
    return InCalm(*wind_in_world, aircraft, options, wind_margin);
  }
  return AgainstWind(*wind_in_world, aircraft, wind_margin);
}

std::vector<WindScenario> Way::Scenarios() const {
  std::vector<WindScenario> scenarios;
  for (const HeadingCase& heading : wind.headings) {
    scenarios.insert(scenarios.end(), heading.scenarios.begin(), heading.scenarios.end());
  }
  return scenarios;
}

std::vector<Way> WaysDown(const std::optional<Eigen::Vector2d>& wind_in_world,
                          const Aircraft& aircraft,
                          const ApproachOptions& options,
                          double wind_margin) {
  return FromEachHeight(aircraft, options, [&](const Aircraft& higher) {
    std::vector<WindCase> cases{MakeWindCase(wind_in_world, higher, options, wind_margin)};
    if (wind_in_world) {
      cases.push_back(AcrossWind(*wind_in_world, higher, options, wind_margin));
    }
    return cases;
  });
}

double PlanReach(const Aircraft& aircraft,
                 const std::optional<Eigen::Vector2d>& wind_in_world,
                 double wind_spread_mps,
                 double least,
                 const ApproachOptions& options) {
  double reach = least;
  const double wind_margin = options.wind_sigma * wind_spread_mps;
  for (const Way& way : WaysDown(wind_in_world, aircraft, options, wind_margin)) {
    if (way.start_height > 0) break;
    for (const WindScenario& scenario : way.Scenarios()) {
      const double path = std::max(scenario.approach_distance, 0.0) + 2.0 * scenario.loiter_radius;
      reach = std::max(reach, path + kReachMarginM);
    }
  }
  return kReachStepM * std::ceil(reach / kReachStepM);
}

double ClimbSlope(const Approach& approach, const Aircraft& aircraft) {
  // FinalLength, solved for the headwind.
  const double headwind = GroundSpeed(aircraft) - approach.approach_distance /
                                                      approach.approach_height * SinkRate(aircraft);
  const double climb = RadFromDeg(aircraft.climb_gradient_deg);
  const double tailwind = std::max(0.0, -headwind);
  return aircraft.landing_airspeed_mps * std::sin(climb) /
         (aircraft.landing_airspeed_mps * std::cos(climb) + tailwind);
}

Approach MakeApproach(const Eigen::Vector3d& touchdown_in_world,
                      double heading,
                      const WindScenario& scenario,
                      LoiterDirection direction,
                      double approach_height) {
  Approach approach;
  approach.touchdown_in_world = touchdown_in_world;
  approach.heading = heading;
  approach.approach_distance = scenario.approach_distance;
  approach.approach_height = approach_height;
  approach.loiter_radius = scenario.loiter_radius;
  approach.crosswind = scenario.crosswind;
  approach.ground_speed = scenario.ground_speed;
  approach.loiter_direction = direction;
  const Eigen::Vector2d start =
      touchdown_in_world.head<2>() - scenario.approach_distance * DirectionOf(heading);
  const Eigen::Vector2d center = start + scenario.loiter_radius * TowardsCenter(heading, direction);
  const double height = touchdown_in_world.z() + approach_height;
  approach.approach_start_in_world = {start.x(), start.y(), height};
  approach.loiter_center_in_world = {center.x(), center.y(), height};
  return approach;
}

std::vector<Eigen::Vector3d> LoiterPolyline(const Approach& approach, int num_points) {
  const int num_steps = std::max(num_points, kMinPolylinePoints);
  // A left turn is counter-clockwise seen from above.
  const double turn = approach.loiter_direction == LoiterDirection::kLeft ? 2.0 * kPi : -2.0 * kPi;
  const Eigen::Vector3d from_center =
      approach.approach_start_in_world - approach.loiter_center_in_world;
  std::vector<Eigen::Vector3d> polyline;
  for (int i = 0; i < num_steps; ++i) {
    const Eigen::AngleAxisd rotation(turn * i / num_steps, Eigen::Vector3d::UnitZ());
    polyline.push_back(approach.loiter_center_in_world + rotation * from_center);
  }
  polyline.push_back(polyline.front());
  return polyline;
}

}  // namespace freelsd
