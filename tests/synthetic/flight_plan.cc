#include "tests/synthetic/flight_plan.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <sstream>
#include <stdexcept>

#include "tests/synthetic/noise.h"

namespace freelsd {
namespace {

enum Purpose : uint64_t { kGusts = 301, kSensors };

// Attitude in gusty air: standard deviation and how long a gust lasts.
constexpr double kGustRollDeg = 2.5;
constexpr double kGustPitchDeg = 1.5;
constexpr double kGustHeightM = 1.0;
constexpr double kGustTimeS = 3.0;
// Photographs of a survey: distance between two, as a share of the height above ground.
constexpr double kSurveySpacingRatio = 0.36;
// Turning around at the end of a leg takes the aircraft this long; nothing is photographed.
constexpr double kTurnTimeS = 12.0;

void Require(bool holds, const char* field, double value, const char* constraint) {
  if (holds) return;
  std::ostringstream message;
  message << "flight." << field << " = " << value << ": must be in " << constraint;
  throw std::invalid_argument(message.str());
}

// Slowly varying error (Ornstein-Uhlenbeck) of a stated standard deviation.
class Drift {
 public:
  Drift(double sd, double time_s) : sd_(sd), time_s_(time_s) {}
  double Next(double dt, std::mt19937_64& random) {
    std::normal_distribution<double> normal;
    const double keep = has_value_ ? std::exp(-dt / time_s_) : 0.0;
    value_ = keep * value_ + std::sqrt(1.0 - keep * keep) * normal(random);
    has_value_ = true;
    return sd_ * value_;
  }

 private:
  double sd_, time_s_;
  double value_ = 0.0;
  bool has_value_ = false;
};

struct Waypoint {
  Eigen::Vector2d place = Eigen::Vector2d::Zero();
  Eigen::Vector2d track = Eigen::Vector2d::UnitY();  // unit
  double time_s = 0.0;
};

// Speed over ground along a track, and the heading that holds it.
double GroundSpeed(const Eigen::Vector2d& track, double airspeed, const Eigen::Vector2d& wind) {
  const double along = wind.dot(track);
  const double across = wind.x() * track.y() - wind.y() * track.x();
  return along + std::sqrt(std::max(airspeed * airspeed - across * across, 1.0));
}

double CrabbedHeading(const Waypoint& waypoint, double airspeed, const Eigen::Vector2d& wind) {
  const double speed = GroundSpeed(waypoint.track, airspeed, wind);
  const Eigen::Vector2d air = speed * waypoint.track - wind;
  return WrapAngle(HeadingOf(air));
}

std::vector<Waypoint> Legs(const FlightOptions& options, const Eigen::Vector2d& wind) {
  const double spacing = options.pattern == FlightPattern::kSurvey
                             ? kSurveySpacingRatio * options.height_above_origin_m
                             : options.airspeed_mps * options.frame_period_s;
  const double area = options.num_frames * spacing * options.leg_spacing_m;
  const int num_legs =
      std::max(1, static_cast<int>(std::lround(std::sqrt(area) / options.leg_spacing_m)));
  const int per_leg = (options.num_frames + num_legs - 1) / num_legs;
  std::vector<Waypoint> waypoints;
  double time_s = 0.0;
  for (int i = 0; i < options.num_frames; ++i) {
    const int leg = i / per_leg, step = i % per_leg;
    const double side = leg % 2 == 0 ? 1.0 : -1.0;
    Waypoint waypoint;
    waypoint.track = {0.0, side};
    waypoint.place = {(leg - 0.5 * (num_legs - 1)) * options.leg_spacing_m,
                      side * (step - 0.5 * (per_leg - 1)) * spacing};
    if (i > 0) {
      time_s += step == 0 ? kTurnTimeS
                          : spacing / GroundSpeed(waypoint.track, options.airspeed_mps, wind);
    }
    waypoint.time_s = time_s;
    waypoints.push_back(waypoint);
  }
  return waypoints;
}

// What the autopilot gets wrong.
class Autopilot {
 public:
  explicit Autopilot(const FlightOptions& options)
      : options_(options), random_(MixSeed(options.seed, kSensors)) {
    const double sign = random_() % 2 == 0 ? 1.0 : -1.0;
    altitude_bias_ = sign * options.noise_scale * options.altitude_bias_m;
  }

  AutopilotSample Report(const AutopilotSample& truth, double dt) {
    const double scale = options_.noise_scale;
    AutopilotSample sample = truth;
    for (int axis = 0; axis < 3; ++axis) {
      sample.position_in_world[axis] +=
          scale * (drift_[axis].Next(dt, random_) + options_.position_white_m * normal_(random_));
    }
    sample.position_in_world.z() += altitude_bias_;
    const double tilt = scale * RadFromDeg(options_.roll_pitch_deg);
    sample.attitude.roll += tilt * normal_(random_);
    sample.attitude.pitch += tilt * normal_(random_);
    sample.attitude.yaw =
        WrapAngle(sample.attitude.yaw + scale * RadFromDeg(yaw_drift_.Next(dt, random_)));
    return sample;
  }

  Eigen::Vector2d ReportWind(const Eigen::Vector2d& wind) {
    const double sd = options_.noise_scale * options_.wind_mps;
    const double east = normal_(random_), north = normal_(random_);
    return wind + sd * Eigen::Vector2d(east, north);
  }

 private:
  FlightOptions options_;
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  Drift drift_[3] = {{options_.position_drift_m, options_.drift_time_s},
                     {options_.position_drift_m, options_.drift_time_s},
                     {options_.position_drift_m, options_.drift_time_s}};
  Drift yaw_drift_{options_.yaw_drift_deg, options_.drift_time_s};
  double altitude_bias_ = 0.0;
};

std::string ImageName(int index) {
  char name[32];
  std::snprintf(name, sizeof name, "frame_%04d.jpg", index + 1);
  return name;
}

}  // namespace

void FlightOptions::Check() const {
  Require(num_frames >= 1 && num_frames <= 100000, "num_frames", num_frames, "[1, 100000]");
  Require(height_above_origin_m >= 20.0 && height_above_origin_m <= 1000.0,
          "height_above_origin_m",
          height_above_origin_m,
          "[20, 1000]");
  Require(airspeed_mps >= 5.0 && airspeed_mps <= 60.0, "airspeed_mps", airspeed_mps, "[5, 60]");
  Require(frame_period_s > 0.0, "frame_period_s", frame_period_s, "(0, inf)");
  Require(leg_spacing_m > 0.0, "leg_spacing_m", leg_spacing_m, "(0, inf)");
  Require(noise_scale >= 0.0 && noise_scale <= 10.0, "noise_scale", noise_scale, "[0, 10]");
}

std::vector<SyntheticExposure> PlanFlight(const FlightOptions& options,
                                          const Eigen::Vector2d& wind_in_world) {
  options.Check();
  const std::vector<Waypoint> waypoints = Legs(options, wind_in_world);
  std::mt19937_64 random(MixSeed(options.seed, kGusts));
  Drift roll(RadFromDeg(kGustRollDeg), kGustTimeS), pitch(RadFromDeg(kGustPitchDeg), kGustTimeS);
  Drift height(kGustHeightM, kGustTimeS);
  Autopilot autopilot(options);
  std::vector<SyntheticExposure> exposures;
  double previous_s = 0.0;
  for (const Waypoint& waypoint : waypoints) {
    const double dt = waypoint.time_s - previous_s;
    previous_s = waypoint.time_s;
    SyntheticExposure exposure;
    exposure.image = ImageName(static_cast<int>(exposures.size()));
    exposure.timestamp_us = options.start_us + std::llround(waypoint.time_s * 1e6);
    exposure.truth.position_in_world << waypoint.place,
        options.height_above_origin_m + height.Next(dt, random);
    exposure.truth.attitude.roll = roll.Next(dt, random);
    exposure.truth.attitude.pitch = pitch.Next(dt, random);
    exposure.truth.attitude.yaw = CrabbedHeading(waypoint, options.airspeed_mps, wind_in_world);
    exposure.reported = autopilot.Report(exposure.truth, dt);
    exposure.reported_wind_in_world = autopilot.ReportWind(wind_in_world);
    exposures.push_back(exposure);
  }
  return exposures;
}

Rigid3d WorldFromBody(const AutopilotSample& sample) {
  return {WorldFromNed() * NedFromBody(sample.attitude), sample.position_in_world};
}

}  // namespace freelsd
