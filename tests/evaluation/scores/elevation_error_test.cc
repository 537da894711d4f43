#include "tests/evaluation/scores/elevation_error.h"

#include <cmath>

#include <doctest/doctest.h>

#include "engine/geometry/geometry.h"

namespace freelsd {
namespace {

// One metre apart, over 100 m by 100 m.
template <typename ErrorAt>
std::vector<HeightError> Errors(ErrorAt error_at) {
  std::vector<HeightError> errors;
  for (int x = -50; x < 50; ++x) {
    for (int y = -50; y < 50; ++y) errors.push_back({{x, y}, error_at(x, y)});
  }
  return errors;
}

double PlaneAt(int x, int y) { return 3.0 + 0.01 * x - 0.02 * y; }

TEST_CASE("elevation error: an exact plane is removed") {
  const DetiltedErrors detilted = Detilt(Errors(PlaneAt));
  CHECK(detilted.plane.offset == doctest::Approx(3.0));
  CHECK(detilted.plane.TiltDeg() == doctest::Approx(DegFromRad(std::atan(std::hypot(0.01, 0.02)))));
  CHECK(detilted.residual.Rms() < 1e-9);
}

TEST_CASE("elevation error: outliers do not move the plane, and stay in the residual") {
  const auto with_house = [](int x, int y) {
    return PlaneAt(x, y) + (x > 30 && y > 30 ? 20.0 : 0.0);
  };
  const DetiltedErrors detilted = Detilt(Errors(with_house));
  CHECK(detilted.plane.offset == doctest::Approx(3.0).epsilon(0.01));
  CHECK(detilted.residual.Rms() == doctest::Approx(20.0 * std::sqrt(0.0361)).epsilon(0.01));
}

TEST_CASE("elevation error: local noise is that within 20 m, whatever the map does over 100 m") {
  const auto wavy = [](int x, int y) {
    constexpr double kNoiseM = 0.1, kWaveM = 1.0;
    const double noise = (x + y) % 2 == 0 ? kNoiseM : -kNoiseM;
    return noise + kWaveM * (std::abs(x) < 30 ? -1.0 : 1.0);
  };
  const DetiltedErrors detilted = Detilt(Errors(wavy));
  CHECK(detilted.residual.Rms() > 0.8);
  CHECK(detilted.local_noise.Percentile(50.0) == doctest::Approx(0.1).epsilon(0.06));
}

TEST_CASE("elevation error: without errors there is no plane and no noise") {
  const DetiltedErrors detilted = Detilt({});
  CHECK(detilted.plane.offset == 0.0);
  CHECK(std::isnan(detilted.residual.Rms()));
  CHECK(std::isnan(detilted.local_noise.Percentile(50.0)));
  CHECK(Detilt({{{1.0, 2.0}, 5.0}}).plane.TiltDeg() == 0.0);
}

}  // namespace
}  // namespace freelsd
