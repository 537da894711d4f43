// What stands in a meadow and is too small for the map of heights.
#include "engine/cover/small_objects.h"

#include <doctest/doctest.h>

#include "tests/engine/cover/photo.h"

namespace freelsd {
namespace {

using photo::Color;
using photo::Paint;
using photo::Painted;

constexpr double kSideM = 60.0;
const Color kStone{132.0, 134.0, 136.0};
const Color kBrownCow{52.0, 64.0, 92.0};

Paint Meadow() {
  return [](const Eigen::Vector2d&) { return photo::kGreen; };
}

// Discs of a colour in a meadow.
Paint MeadowWith(const std::vector<Eigen::Vector2d>& places, double radius_m, const Color& color) {
  return [=](const Eigen::Vector2d& place) -> Color {
    for (const Eigen::Vector2d& center : places) {
      if ((place - center).norm() < radius_m) return color;
    }
    return photo::kGreen;
  };
}

bool IsFoundAt(const Orthophoto& photo, const cv::Mat1b& mask, const Eigen::Vector2d& place) {
  return mask(*photo.grid.CellAt(place)) == 255;
}

TEST_CASE("small objects: boulders and animals are found, and the meadow about them is none") {
  const std::vector<Eigen::Vector2d> places{
      {-18.0, 12.0}, {-16.0, 12.5}, {3.0, -4.0}, {20.0, 21.0}, {25.0, -28.5}};
  for (const Color& color : {kStone, kBrownCow, Color(230.0, 232.0, 232.0)}) {
    const Orthophoto photo = Painted(kSideM, MeadowWith(places, 0.7, color));
    const cv::Mat1b mask = SmallObjects(photo, {});
    for (const Eigen::Vector2d& place : places) {
      CAPTURE(place.x());
      CHECK(IsFoundAt(photo, mask, place));
    }
    const double found_m2 = cv::countNonZero(mask) * 0.25 * 0.25;
    CHECK(found_m2 < 5 * kPi * 1.4 * 1.4);
  }
}

TEST_CASE("small objects: a meadow of two greens, in light that changes, has none") {
  const auto two_greens = [](const Eigen::Vector2d& place) -> Color {
    const double light = 1.0 + 0.2 * std::sin(place.x() / 9.0) + 0.1 * std::sin(place.y() / 5.0);
    const bool is_lush = std::sin(place.x() / 4.0 + place.y() / 7.0) > 0.3;
    return light * (is_lush ? Color(58.0, 128.0, 70.0) : photo::kGreen);
  };
  CHECK(cv::countNonZero(SmallObjects(Painted(kSideM, Meadow()), {})) == 0);
  CHECK(cv::countNonZero(SmallObjects(Painted(kSideM, two_greens), {})) == 0);
}

TEST_CASE("small objects: one beside a hedge is found as well") {
  const auto hedge = [](const Eigen::Vector2d& place) -> Color {
    if (place.x() > 3.5 && place.x() < 6.0) return {30.0, 62.0, 40.0};
    return (place - Eigen::Vector2d(0.0, 5.0)).norm() < 0.8 ? kStone : photo::kGreen;
  };
  const Orthophoto photo = Painted(kSideM, hedge);
  CHECK(IsFoundAt(photo, SmallObjects(photo, {}), {0.0, 5.0}));
}

TEST_CASE("small objects: too small a thing is none, nor is what was not seen") {
  const std::vector<Eigen::Vector2d> place{{3.0, -4.0}};
  const Orthophoto speck = Painted(kSideM, MeadowWith(place, 0.2, kStone));
  CHECK(cv::countNonZero(SmallObjects(speck, {})) == 0);
  Orthophoto hole = Painted(kSideM, MeadowWith(place, 0.7, kStone));
  photo::MakeUnseen(hole, {120, 120, 30, 30});
  CHECK(cv::countNonZero(SmallObjects(hole, {})) == 0);
}

TEST_CASE("small objects: the fewer deviations make one, the more is found") {
  const Orthophoto photo =
      Painted(kSideM, MeadowWith({{3.0, -4.0}, {-9.0, 9.0}}, 0.7, Color(76.0, 122.0, 90.0)));
  CoverOptions options;
  cv::Mat1b more;
  for (const double deviations : {2.0, 4.0, 7.0, 12.0}) {
    options.min_object_deviations = deviations;
    const cv::Mat1b found = SmallObjects(photo, options);
    if (!more.empty()) CHECK(cv::countNonZero(found & ~more) == 0);
    more = found;
  }
}

}  // namespace
}  // namespace freelsd
