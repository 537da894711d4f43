#include "server/recall/geoid/geoid.h"

#include <cmath>
#include <thread>
#include <vector>

#include <doctest/doctest.h>

namespace freelsd {
namespace {

TEST_CASE("geoid: heights are those that NGA publishes for EGM96") {
  // The test points of NGA's own program for EGM96 (F477): latitude, longitude, height.
  constexpr double kPoints[][3] = {{38.6281550, 269.7791550, -31.629},
                                   {-14.6212170, 305.0211140, -2.966},
                                   {46.8743190, 102.4487290, -43.572},
                                   {-23.6174460, 133.8747120, 15.868},
                                   {38.6254730, 359.9995000, 50.065},
                                   {-0.4667440, 0.0023000, 17.330}};
  // Its interpolation is of a higher degree.
  constexpr double kMaxErrorM = 0.1;
  Geoid geoid;
  for (const auto& point : kPoints) {
    CAPTURE(point[0]);
    const auto height = geoid.HeightAt(point[0], point[1]);
    REQUIRE(height);
    CHECK(std::abs(*height - point[2]) < kMaxErrorM);
  }
}

TEST_CASE("geoid: every place of the earth has a height, and it has no steps") {
  constexpr double kMaxStepM = 0.01;
  constexpr double kAside = 1e-6;
  Geoid geoid;
  for (const double latitude_deg : {-90.0, -60.25, 0.0, 47.0, 90.0}) {
    for (const double longitude_deg : {-180.0, -179.75, 0.0, 8.25, 180.0}) {
      const auto at = geoid.HeightAt(latitude_deg, longitude_deg);
      const auto west = geoid.HeightAt(latitude_deg, longitude_deg - kAside);
      REQUIRE(at);
      REQUIRE(west);
      CHECK(std::abs(*at) < kMaxGeoidHeightM);
      CHECK(std::abs(*at - *west) < kMaxStepM);
    }
  }
  // Over a pole all longitudes meet.
  CHECK(std::abs(*geoid.HeightAt(90.0, 8.0) - *geoid.HeightAt(90.0, -100.0)) < kMaxStepM);
}

TEST_CASE("geoid: threads that ask at once get the same heights") {
  Geoid geoid;
  std::vector<double> heights(8);
  std::vector<std::thread> threads;
  threads.reserve(heights.size());
  for (double& height : heights) {
    threads.emplace_back(
        [&geoid, &height] { height = geoid.HeightAt(47.1, 8.1).value_or(-999.0); });
  }
  for (std::thread& thread : threads) thread.join();
  for (const double height : heights) CHECK(height == heights[0]);
  CHECK(heights[0] == doctest::Approx(*Geoid().HeightAt(47.1, 8.1)));
}

}  // namespace
}  // namespace freelsd
