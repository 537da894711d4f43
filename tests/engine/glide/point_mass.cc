#include "tests/engine/glide/point_mass.h"

#include <algorithm>
#include <cmath>

namespace freelsd {
namespace {

constexpr double kStepS = 0.05;
constexpr double kExtraBankDeg = 8.0;
constexpr double kAheadS = 1.2;
constexpr double kGravity = 9.81;

Performance AtLandingSpeed(Aircraft aircraft) {
  aircraft.glide_airspeed_mps = aircraft.landing_airspeed_mps;
  return PerformanceOf(aircraft);
}

}  // namespace

PointMass::PointMass(const std::vector<DescentPoint>& points,
                     size_t arrival,
                     const GlideStart& start,
                     const Aircraft& aircraft)
    : points_(points),
      arrival_(arrival),
      gliding_(PerformanceOf(aircraft)),
      landing_(AtLandingSpeed(aircraft)),
      wind_(start.wind_in_world.value_or(Eigen::Vector2d::Zero())),
      position_(start.position_in_world),
      heading_(AirHeading(start.heading.value_or(0.0), wind_, gliding_.Airspeed())),
      max_lateral_(kGravity * std::tan(RadFromDeg(aircraft.max_bank_deg + kExtraBankDeg))) {}

double PointMass::FlyTo(size_t end) {
  while (segment_ + 1 <= end && Step()) {
  }
  return position_.z();
}

Eigen::Vector2d PointMass::Ahead() {
  const double airspeed = gliding_.Airspeed();
  for (; segment_ + 1 < points_.size(); ++segment_) {
    const Eigen::Vector2d along = PlaceOf(segment_ + 1) - PlaceOf(segment_);
    const double length = along.norm();
    const Eigen::Vector2d done = position_.head<2>() - PlaceOf(segment_);
    if (length > 1e-6 && done.dot(along) < length * length) {
      const double aside = done.x() * along.y() / length - done.y() * along.x() / length;
      max_track_error_ = std::max(max_track_error_, std::abs(aside));
      return PointFrom(segment_, done.dot(along) / length + kAheadS * airspeed);
    }
  }
  return PlaceOf(points_.size() - 1);
}

Eigen::Vector2d PointMass::PointFrom(size_t i, double length) const {
  for (; i + 1 < points_.size(); ++i) {
    const Eigen::Vector2d along = PlaceOf(i + 1) - PlaceOf(i);
    if (length <= along.norm()) return PlaceOf(i) + length * along.normalized();
    length -= along.norm();
  }
  return PlaceOf(points_.size() - 1);
}

bool PointMass::Step() {
  if (segment_ + 1 >= points_.size() || time_ >= 2.0 * points_.back().time_s + 60.0) return false;
  const Eigen::Vector2d way = Ahead() - position_.head<2>();
  const Performance& performance = segment_ >= arrival_ ? landing_ : gliding_;
  const double speed = performance.Airspeed();
  const double wanted = AirHeading(HeadingOf(way), wind_, speed);
  const double lateral =
      std::clamp(2.0 * speed / kAheadS * std::sin(std::remainder(wanted - heading_, 2.0 * kPi)),
                 -max_lateral_,
                 max_lateral_);
  heading_ += lateral / speed * kStepS;
  const Eigen::Vector2d ground = speed * DirectionOf(heading_) + wind_;
  position_.head<2>() += kStepS * ground;
  position_.z() -= kStepS * SinkRateTurning(performance.straight, std::abs(lateral));
  time_ += kStepS;
  return true;
}

}  // namespace freelsd
