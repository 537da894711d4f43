#include "engine/approach/flight_path.h"

#include <cmath>

namespace freelsd {
namespace {

constexpr double kGravity = 9.81;  // m/s^2

}  // namespace

double ApproachDistance(const Aircraft& aircraft, double wind_speed) {
  const double angle = RadFromDeg(aircraft.flight_path_angle_deg);
  const double drift = RadFromDeg(aircraft.crosswind_uncertainty_deg);
  return (aircraft.landing_airspeed_mps * std::cos(angle) - wind_speed * std::cos(drift)) /
         (aircraft.landing_airspeed_mps * std::sin(angle)) * aircraft.approach_height_m;
}

double LoiterRadius(const Aircraft& aircraft, double wind_speed) {
  const double angle = RadFromDeg(aircraft.flight_path_angle_deg);
  const double ground_speed = aircraft.landing_airspeed_mps * std::cos(angle) + wind_speed;
  return ground_speed * ground_speed / (kGravity * std::tan(RadFromDeg(aircraft.max_bank_deg)));
}

std::optional<Approach> ApproachOf(const Leg& leg, const Aircraft& aircraft) {
  const double distance = ApproachDistance(aircraft, leg.wind_speed);
  // A final that ends inside the touchdown disc is no final: the wind carries as fast as we fly.
  if (distance <= aircraft.touchdown_uncertainty_m) return std::nullopt;
  Approach approach;
  approach.touchdown_in_world = leg.touchdown_in_world;
  approach.heading = leg.heading;
  approach.approach_distance = distance;
  approach.approach_height = aircraft.approach_height_m;
  approach.loiter_radius = LoiterRadius(aircraft, leg.wind_speed);
  const Eigen::Vector2d travel = DirectionOf(leg.heading);
  approach.approach_start_in_world = leg.touchdown_in_world;
  approach.approach_start_in_world.head<2>() -= travel * distance;
  approach.approach_start_in_world.z() += aircraft.approach_height_m;
  return approach;
}

Eigen::Vector3d LoiterCenter(const Approach& approach, LoiterDirection direction) {
  const Eigen::Vector2d travel = DirectionOf(approach.heading);
  const Eigen::Vector2d left(-travel.y(), travel.x());
  const double side = direction == LoiterDirection::kLeft ? 1.0 : -1.0;
  Eigen::Vector3d center = approach.approach_start_in_world;
  center.head<2>() += side * approach.loiter_radius * left;
  return center;
}

std::vector<Eigen::Vector3d> LoiterPolyline(const Approach& approach, int num_points) {
  const Eigen::Vector2d from_center =
      (approach.approach_start_in_world - approach.loiter_center_in_world).head<2>();
  // A left turn goes counter-clockwise.
  const double turn = approach.loiter_direction == LoiterDirection::kLeft ? 1.0 : -1.0;
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i <= num_points; ++i) {
    const Eigen::Rotation2Dd rotation(turn * 2.0 * kPi * (i % num_points) / num_points);
    Eigen::Vector3d point = approach.loiter_center_in_world;
    point.head<2>() += rotation * from_center;
    points.push_back(point);
  }
  return points;
}

std::vector<double> HeadingsFor(const std::optional<Eigen::Vector2d>& wind_in_world,
                                const ApproachOptions& options) {
  if (wind_in_world && wind_in_world->norm() >= options.calm_wind_mps) {
    return {HeadingOf(-*wind_in_world)};
  }
  std::vector<double> headings;
  const int num_headings = static_cast<int>(std::ceil(360.0 / options.heading_step_deg));
  for (int i = 0; i < num_headings; ++i) headings.push_back(2.0 * kPi * i / num_headings);
  return headings;
}

}  // namespace freelsd
