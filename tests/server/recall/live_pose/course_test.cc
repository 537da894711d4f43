#include "server/recall/live_pose/course.h"

#include <algorithm>
#include <cmath>

#include <doctest/doctest.h>

#include "engine/geometry/geometry.h"

namespace freelsd {
namespace {

constexpr int64_t kStartUs = 1700000000000000;
constexpr double kMaxCourseErrorDeg = 12.0;

PassedPosition At(double east_m, double north_m, double seconds) {
  const int64_t time_us = kStartUs + static_cast<int64_t>(seconds * 1e6);
  return {LocalFrame({47.0, 8.0, 500.0}).GeoFromWorld({east_m, north_m, 0.0}), time_us, time_us};
}

// The latest first.
std::vector<PassedPosition> Straight(double speed_mps, double course_deg, double period_s) {
  std::vector<PassedPosition> passed;
  for (int i = 0; i * period_s <= 6.0; ++i) {
    const double way_m = speed_mps * (6.0 - i * period_s);
    const double course = RadFromDeg(course_deg);
    passed.push_back(At(way_m * std::sin(course), way_m * std::cos(course), 6.0 - i * period_s));
  }
  return passed;
}

double ErrorDeg(const std::optional<double>& course_deg, double expected_deg) {
  REQUIRE(course_deg);
  CHECK(*course_deg >= 0.0);
  CHECK(*course_deg < 360.0);
  return std::abs(std::remainder(*course_deg - expected_deg, 360.0));
}

TEST_CASE("course: it is that of the last positions, at any rate of samples") {
  for (const double course_deg : {0.0, 90.0, 217.0, 359.0}) {
    for (const double period_s : {0.02, 0.1, 1.0}) {
      CAPTURE(course_deg);
      CAPTURE(period_s);
      const auto course = CourseDeg(Straight(15.0, course_deg, period_s));
      CHECK(ErrorDeg(course, course_deg) < 0.5);
    }
  }
}

TEST_CASE("course: noise of positions turns it by little, and does not make one where none is") {
  std::vector<PassedPosition> flying = Straight(15.0, 90.0, 0.1);
  std::vector<PassedPosition> standing = Straight(0.0, 90.0, 0.1);
  for (size_t i = 0; i < flying.size(); ++i) {
    const double noise_deg = (i % 2 == 0 ? 1.5 : -1.5) / 111195.0;
    flying[i].place.latitude_deg += noise_deg;
    standing[i].place.latitude_deg += noise_deg;
  }
  CHECK(ErrorDeg(CourseDeg(flying), 90.0) < kMaxCourseErrorDeg);
  CHECK_FALSE(CourseDeg(standing));
}

TEST_CASE("course: a jump, a circle and too few or too old positions tell none") {
  CHECK_FALSE(CourseDeg({}));
  CHECK_FALSE(CourseDeg({At(0, 0, 0)}));
  // Two positions may be a jump of one.
  CHECK_FALSE(CourseDeg({At(0, 30, 1), At(0, 0, 0)}));
  CHECK_FALSE(CourseDeg({At(0, 900, 2), At(0, 450, 1), At(0, 0, 0)}));
  // Once around while the wind carries it along.
  CHECK_FALSE(CourseDeg({At(22, 0, 3), At(11, 18, 2), At(6, -18, 1), At(0, 0, 0)}));
  // Ten seconds apart.
  CHECK_FALSE(CourseDeg({At(0, 260, 20), At(0, 130, 10), At(0, 0, 0)}));
  // The clock of the autopilot began anew, and the former start passed here at these times.
  std::vector<PassedPosition> again{At(0, 40, 3), At(0, 20, 2), At(0, 0, 1)};
  REQUIRE(CourseDeg(again));
  again[1].arrived_at_us -= 3600 * int64_t{1000000};
  again[2].arrived_at_us -= 3600 * int64_t{1000000};
  CHECK_FALSE(CourseDeg(again));
}

TEST_CASE("course: what was sent later but measured before the latest is passed over") {
  std::vector<PassedPosition> passed = Straight(15.0, 45.0, 0.5);
  std::swap(passed[1], passed[2]);
  CHECK(ErrorDeg(CourseDeg(passed), 45.0) < 0.5);
  // The latest one is of the past: nothing before it is older.
  passed.insert(passed.begin(), At(0, 0, -3600));
  CHECK_FALSE(CourseDeg(passed));
}

}  // namespace
}  // namespace freelsd
