#include "engine/wind/wind.h"

#include <cmath>
#include <random>
#include <stdexcept>

#include <doctest/doctest.h>

namespace freelsd {
namespace {

WindSample Sample(double east, double wind_east, double wind_north, int64_t timestamp_us) {
  return {.position_in_world = {east, 0.0, 80.0},
          .wind_in_world = {wind_east, wind_north},
          .timestamp_us = timestamp_us};
}

TEST_CASE("wind: the average is exponentially weighted, oldest first, whatever the order given") {
  const WindOptions options{.radius_m = 300.0, .smoothing = 0.25};
  const std::vector<WindSample> samples{
      Sample(0, 8, 0, 30), Sample(0, 0, 4, 10), Sample(0, 4, 4, 20)};
  const auto estimate = WindAt({0, 0}, samples, options);
  REQUIRE(estimate);
  // (0, 4), then a quarter of the way to (4, 4), then to (8, 0).
  CHECK(estimate->wind_in_world.x() == doctest::Approx(1.0 + 0.25 * 7.0));
  CHECK(estimate->wind_in_world.y() == doctest::Approx(4.0 - 0.25 * 4.0));
  CHECK(estimate->num_samples == 3);
  CHECK(estimate->last_sample_us == 30);
}

TEST_CASE("wind: vectors are averaged, so directions about north do not become south") {
  const double a = 10.0 * std::acos(-1.0) / 180.0;
  const std::vector<WindSample> samples{Sample(0, 5 * std::sin(a), 5 * std::cos(a), 1),
                                        Sample(0, -5 * std::sin(a), 5 * std::cos(a), 2)};
  const auto estimate = WindAt({0, 0}, samples, {.radius_m = 300.0, .smoothing = 0.5});
  CHECK(std::abs(estimate->wind_in_world.x()) < 1e-9);
  CHECK(estimate->wind_in_world.y() == doctest::Approx(5 * std::cos(a)));
}

TEST_CASE("wind: only samples within the radius count, height does not matter, none is nothing") {
  const std::vector<WindSample> samples{Sample(299, 1, 0, 1), Sample(301, 9, 0, 2)};
  const auto estimate = WindAt({0, 0}, samples, {});
  REQUIRE(estimate);
  CHECK(estimate->num_samples == 1);
  CHECK(estimate->wind_in_world.x() == 1.0);
  CHECK(estimate->spread_mps == 0.0);
  CHECK_FALSE(WindAt({-700, 0}, samples, {}));
  CHECK_FALSE(WindAt({0, 0}, {}, {}));
}

TEST_CASE("wind: a measurement that is no number is left out") {
  const auto estimate = WindAt({0, 0}, {Sample(0, NAN, 0, 1), Sample(0, 2, 1, 2)}, {});
  REQUIRE(estimate);
  CHECK(estimate->num_samples == 1);
  CHECK(estimate->wind_in_world == Eigen::Vector2d(2, 1));
}

TEST_CASE("wind: noise averages out and its spread per axis is told") {
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0.0, 0.8);
  std::vector<WindSample> samples;
  samples.reserve(500);
  for (int i = 0; i < 500; ++i) {
    samples.push_back(Sample(0, 3.0 + noise(random), -4.0 + noise(random), i));
  }
  const auto estimate = WindAt({0, 0}, samples, {});
  constexpr double kMaxErrorMps = 0.6;  // the average remembers about 19 samples
  CHECK((estimate->wind_in_world - Eigen::Vector2d(3, -4)).norm() < kMaxErrorMps);
  CHECK(std::abs(estimate->spread_mps - 0.8) < 0.1);
}

TEST_CASE("wind: what was measured too long ago says nothing of now") {
  const std::vector<WindSample> samples{Sample(0, 1, 0, 0), Sample(0, 2, 0, 3'000'000'000)};
  const auto recent = RecentSamples(samples, 3'600'000'000, {.max_age_s = 1800.0});
  REQUIRE(recent.size() == 1);
  CHECK(recent[0].wind_in_world.x() == 2.0);
  CHECK(RecentSamples(samples, 6'000'000'000, {.max_age_s = 1800.0}).empty());
  // Measured after the image: it is not old.
  CHECK(RecentSamples(samples, 0, {.max_age_s = 1.0}).size() == 2);
}

TEST_CASE("wind: options out of bounds are refused by name") {
  CHECK_NOTHROW(WindOptions{}.Check());
  CHECK_THROWS_WITH_AS((WindOptions{.radius_m = 0.0, .smoothing = 0.1}.Check()),
                       "wind.radius_m = 0: must be positive and finite",
                       std::invalid_argument);
  CHECK_THROWS_WITH_AS((WindOptions{.radius_m = 10.0, .smoothing = 1.5}.Check()),
                       "wind.smoothing = 1.5: must be in (0, 1]",
                       std::invalid_argument);
}

}  // namespace
}  // namespace freelsd
