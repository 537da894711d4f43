#include "server/recall/same_place.h"

#include <cmath>

#include "engine/approach/approach.h"

namespace freelsd {
namespace {

constexpr double kSamePlaceM = 30.0;
constexpr double kSameHeadingDeg = 15.0;

}  // namespace

Landing LandingOf(const GeoPoint& touchdown,
                  double heading,
                  const std::optional<Eigen::Vector2d>& wind_in_world) {
  const bool is_free = !wind_in_world || wind_in_world->norm() < ApproachOptions{}.calm_wind_mps;
  return {touchdown, heading, is_free};
}

bool IsSamePlace(const Landing& a, const Landing& b) {
  const Eigen::Vector3d way = LocalFrame(a.touchdown).WorldFromGeo(b.touchdown);
  if (way.head<2>().norm() > kSamePlaceM) return false;
  if (a.is_heading_free || b.is_heading_free) return true;
  const double turn = std::abs(std::remainder(a.heading - b.heading, 2.0 * kPi));
  return turn <= RadFromDeg(kSameHeadingDeg);
}

}  // namespace freelsd
