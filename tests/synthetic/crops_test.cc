#include "tests/synthetic/crops.h"

#include <algorithm>

#include <doctest/doctest.h>

namespace freelsd {
namespace {

TEST_CASE("crops: they stand 0.3 m and more, and every field of cereals has tracks of a sprayer") {
  double lowest = 9.0, highest = 0.0;
  for (int variant = 0; variant < 256; ++variant) {
    const CropStand crop = CropOf(static_cast<uint8_t>(variant));
    lowest = std::min(lowest, crop.height_m);
    highest = std::max(highest, crop.height_m);
    CHECK(crop.is_maize == (crop.tramline_spacing_m == 0.0));
  }
  CHECK(lowest == doctest::Approx(0.3));
  CHECK(highest == doctest::Approx(1.6));
}

TEST_CASE("crops: two wheel tracks every working width, and one round along the border") {
  const Eigen::Vector2d size(100.0, 60.0);
  const CropStand crop{.height_m = 0.6, .tramline_spacing_m = 24.0};
  // Passes lie 12 and 36 m from the lower border; the first is the round itself.
  for (const double across : {11.05, 12.95, 35.05, 36.95}) {
    CHECK(IsBare(crop, {50.0, across}, size));
  }
  for (const double across : {5.0, 12.0, 20.0, 36.0})
    CHECK_FALSE(IsBare(crop, {50.0, across}, size));
  CHECK(IsBare(crop, {11.05, 25.0}, size));       // the round on the short side
  CHECK_FALSE(IsBare(crop, {5.0, 36.95}, size));  // passes end where it begins
}

TEST_CASE("crops: soil shows between rows of young maize only") {
  const Eigen::Vector2d size(100.0, 60.0);
  const auto share_of_soil = [&](double height_m) {
    const CropStand maize{.is_maize = true, .height_m = height_m};
    int num_bare = 0;
    for (int i = 0; i < 300; ++i) num_bare += IsBare(maize, {50.0, 20.0 + 0.05 * i}, size);
    return num_bare / 300.0;
  };
  CHECK(share_of_soil(0.3) > 0.3);
  CHECK(share_of_soil(0.6) < share_of_soil(0.3));
  CHECK(share_of_soil(1.2) == 0.0);
}

}  // namespace
}  // namespace freelsd
