#include "server/recall/same_place.h"

#include <doctest/doctest.h>

namespace freelsd {
namespace {

constexpr GeoPoint kPlace{47.0, 8.0, 400.0};

GeoPoint North(double metres) {
  return {kPlace.latitude_deg + metres / 111195.0, kPlace.longitude_deg, kPlace.altitude_m};
}

TEST_CASE("same place: 30 m apart and 15 degrees off, no more") {
  const Eigen::Vector2d wind(3.0, 0.0);
  const Landing landing = LandingOf(kPlace, 0.0, wind);
  CHECK(IsSamePlace(landing, LandingOf(North(29.0), RadFromDeg(14.0), wind)));
  CHECK(IsSamePlace(landing, LandingOf(North(29.0), RadFromDeg(346.0), wind)));
  CHECK_FALSE(IsSamePlace(landing, LandingOf(North(31.0), 0.0, wind)));
  CHECK_FALSE(IsSamePlace(landing, LandingOf(kPlace, RadFromDeg(16.0), wind)));
}

TEST_CASE("same place: in calm or unknown wind any heading is the same") {
  const Landing north = LandingOf(kPlace, 0.0, Eigen::Vector2d(3.0, 0.0));
  CHECK(IsSamePlace(north, LandingOf(kPlace, kPi, std::nullopt)));
  CHECK(IsSamePlace(LandingOf(kPlace, kPi, Eigen::Vector2d(0.0, 0.1)), north));
  CHECK_FALSE(IsSamePlace(north, LandingOf(North(31.0), 0.0, std::nullopt)));
}

}  // namespace
}  // namespace freelsd
