// A thing on the strip must be told, other light must not, and what cannot be compared is unknown.
#include "engine/watch/watch.h"

#include <cmath>

#include <doctest/doctest.h>
#include <opencv2/core/utility.hpp>

#include "tests/engine/watch/meadow_strip.h"

namespace freelsd {
namespace {

using watched::AboveStrip;
using watched::Grass;
using watched::kFlownHeightM;
using watched::Lit;
using watched::PhotoOf;
using watched::StoredStrip;
using watched::With;

constexpr double kMaxPlaceErrorM = 0.6;
constexpr double kMaxSizeErrorM = 0.8;
const cv::Vec3d kSilver(200.0, 200.0, 200.0), kDark(45.0, 44.0, 42.0);
const Eigen::Vector2d kCarPlace(8.0, 1.0), kCarSize(4.4, 1.8);

// The light of the afternoon: darker, yellower, and falling off towards the east.
cv::Vec3d Afternoon(const Eigen::Vector2d& place) {
  const double gain = 0.75 - 0.004 * place.x();
  return {0.88 * gain, gain, 1.04 * gain};
}

// What a thing's shadow does: the light of the sky alone.
const cv::Vec3d kShade(0.42, 0.36, 0.33);

StripLook LookAt(const watched::Look& stored, const watched::Look& now) {
  return LookAtStrip(StoredStrip(stored), PhotoOf(now, AboveStrip()), {});
}

TEST_CASE("watch: the same ground in other light shows nothing new") {
  const StripLook look = LookAt(Grass, Lit(Grass, Afternoon));
  CHECK(look.result == LookResult::kCompared);
  CHECK(look.compared_ratio > 0.95);
  CHECK(look.things.empty());
}

TEST_CASE("watch: a pose that errs by metres and degrees is corrected") {
  WatchedPhoto photo = PhotoOf(With(Grass, kCarPlace, kCarSize, kSilver), AboveStrip());
  photo.world_from_camera = SceneView({6.5, -4.0, kFlownHeightM + 2.0}, 0.24, 3.0, 0.0);
  const StripLook look = LookAtStrip(StoredStrip(Grass), photo, {});
  REQUIRE(look.result == LookResult::kCompared);
  CHECK(look.offset_in_world.norm() > 1.0);
  REQUIRE(look.things.size() == 1);
  CHECK((look.things[0].place_in_world.head<2>() - kCarPlace).norm() < kMaxPlaceErrorM);
}

TEST_CASE("watch: a car on the strip is found where it stands, and as large as it is") {
  for (const cv::Vec3d& color : {kSilver, kDark, cv::Vec3d(50.0, 45.0, 160.0)}) {
    const StripLook look = LookAt(Grass, Lit(With(Grass, kCarPlace, kCarSize, color), Afternoon));
    REQUIRE(look.result == LookResult::kCompared);
    REQUIRE(!look.things.empty());
    const NewThing& car = look.things[0];
    CHECK(car.cue == WatchCue::kColor);
    CHECK((car.place_in_world.head<2>() - kCarPlace).norm() < kMaxPlaceErrorM);
    CHECK(std::abs(car.length_m - kCarSize.x()) < kMaxSizeErrorM);
    CHECK(std::abs(car.width_m - kCarSize.y()) < kMaxSizeErrorM);
  }
}

TEST_CASE("watch: a person in dark clothes, and one in green ones with a shadow, are found") {
  const Eigen::Vector2d place(-6.0, 2.0);
  CHECK(!LookAt(Grass, With(Grass, place, {0.6, 0.5}, kDark)).things.empty());
  const watched::Look shaded = Lit(Grass, [&](const Eigen::Vector2d& at) {
    const Eigen::Vector2d offset = (at - place).cwiseAbs();
    return offset.x() < 1.2 && offset.y() < 0.25 ? kShade : cv::Vec3d(1.0, 1.0, 1.0);
  });
  const StripLook look = LookAt(Grass, shaded);
  REQUIRE(!look.things.empty());
  CHECK((look.things[0].place_in_world.head<2>() - place).norm() < kMaxPlaceErrorM);
}

TEST_CASE(
    "watch: on grey ground, where colours tell nothing, a pale thing with its shadow is found") {
  const watched::Look grey = [](const Eigen::Vector2d& place) {
    const double gain = Grass(place)[1] / 145.0;
    return gain * cv::Vec3d(118.0, 122.0, 124.0);
  };
  const Eigen::Vector2d place(-6.0, 2.0);
  const watched::Look shaded = With(grey, place + Eigen::Vector2d(1.3, 0.0), {1.3, 1.3}, kDark);
  const StripLook look = LookAt(grey, With(shaded, place, {1.3, 1.3}, {215.0, 218.0, 215.0}));
  REQUIRE(look.result == LookResult::kCompared);
  REQUIRE(!look.things.empty());
  CHECK((look.things[0].place_in_world.head<2>() - place).norm() < 1.3 + kMaxPlaceErrorM);
}

TEST_CASE("watch: a dark car under the edge of a cloud's shadow is found") {
  const watched::Look cloud =
      Lit(With(Grass, kCarPlace, kCarSize, kDark), [](const Eigen::Vector2d& at) {
        const double share = 1.0 / (1.0 + std::exp(-(at.x() - kCarPlace.x()) / 2.0));
        return cv::Vec3d(1.0, 1.0, 1.0) - share * 0.5 * cv::Vec3d(0.9, 1.0, 1.05);
      });
  const StripLook look = LookAt(Grass, cloud);
  REQUIRE(!look.things.empty());
  CHECK((look.things[0].place_in_world.head<2>() - kCarPlace).norm() < 2.0 * kMaxPlaceErrorM);
}

TEST_CASE("watch: the large shadow of low sun, whose rim crosses the strip, is no thing") {
  const watched::Look shadow = Lit(Grass, [](const Eigen::Vector2d& at) {
    const double rim = 2.0 + 1.5 * std::sin(0.8 * at.x()) + 0.15 * at.x();
    return at.y() > rim ? kShade : cv::Vec3d(1.0, 1.0, 1.0);
  });
  const StripLook look = LookAt(Grass, shadow);
  CHECK(look.result == LookResult::kCompared);
  CHECK(look.things.empty());
}

TEST_CASE("watch: what stands beside the strip is not on it") {
  CHECK(LookAt(Grass, With(Grass, {8.0, 9.0}, kCarSize, kSilver)).things.empty());
}

TEST_CASE("watch: a thing that is gone is not new") {
  const StripLook look = LookAt(With(Grass, kCarPlace, kCarSize, kSilver), Grass);
  CHECK(look.result == LookResult::kCompared);
  CHECK(look.things.empty());
}

TEST_CASE("watch: the shadow of a cloud and that of a tree beside the strip are no things") {
  const watched::Look cloud = Lit(Grass, [](const Eigen::Vector2d& at) {
    const double share = 1.0 / (1.0 + std::exp(-(at.x() + 0.5 * at.y()) / 3.0));
    return cv::Vec3d(1.0, 1.0, 1.0) - share * 0.5 * cv::Vec3d(0.9, 1.0, 1.05);
  });
  CHECK(LookAt(Grass, cloud).things.empty());
  const watched::Look tree = Lit(Grass, [](const Eigen::Vector2d& at) {
    const double ratio = std::hypot(at.x() / 4.0, (at.y() - 7.0) / 8.0);
    return ratio < 1.0 ? kShade : cv::Vec3d(1.0, 1.0, 1.0);
  });
  const StripLook look = LookAt(Grass, tree);
  CHECK(look.result == LookResult::kCompared);
  CHECK(look.things.empty());
}

TEST_CASE("watch: wet grass, darker and of stronger colour, is no thing") {
  const watched::Look wet = [](const Eigen::Vector2d& place) {
    const cv::Vec3d color = Grass(place);
    const double mean = (color[0] + color[1] + color[2]) / 3.0;
    const cv::Vec3d grey(mean, mean, mean);
    return 0.8 * (grey + 1.15 * (color - grey));
  };
  const StripLook look = LookAt(Grass, wet);
  CHECK(look.result == LookResult::kCompared);
  CHECK(look.things.empty());
}

TEST_CASE("watch: what cannot be compared is unknown, with a reason") {
  const StripPicture strip = StoredStrip(Grass);
  const Rigid3d beside = SceneView({150.0, 0.0, kFlownHeightM}, 0.0);
  CHECK(LookAtStrip(strip, PhotoOf(Grass, beside), {}).result == LookResult::kNotShown);
  const Rigid3d high = SceneView({0.0, 0.0, 250.0}, 0.0);
  CHECK(LookAtStrip(strip, PhotoOf(Grass, high), {}).result == LookResult::kTooCoarse);
  const watched::Look other = [](const Eigen::Vector2d& place) {
    return Grass(place + Eigen::Vector2d(411.0, 87.0));
  };
  CHECK(LookAt(Grass, other).result == LookResult::kNotRegistered);
  const watched::Look even = [](const Eigen::Vector2d&) { return cv::Vec3d(60.0, 145.0, 120.0); };
  CHECK(LookAt(Grass, even).result == LookResult::kNotRegistered);
  StripPicture unseen = strip;
  unseen.picture = cv::Mat4b(strip.picture.size(), cv::Vec4b::all(0));
  CHECK(LookAtStrip(unseen, PhotoOf(Grass, AboveStrip()), {}).result != LookResult::kCompared);
  unseen = strip;
  unseen.elevation = cv::Mat1f(120, 120, std::nanf(""));
  CHECK(LookAtStrip(unseen, PhotoOf(Grass, AboveStrip()), {}).result != LookResult::kCompared);
}

TEST_CASE("watch: ground behind a wall is not compared") {
  StripPicture strip = StoredStrip(Grass);
  // South of the strip, between it and the camera.
  strip.upper.row(60 + 8).setTo(40.0f);
  const Rigid3d south = SceneView({0.0, -35.0, kFlownHeightM}, 0.0, 30.0);
  const StripLook open = LookAtStrip(StoredStrip(Grass), PhotoOf(Grass, south), {});
  const StripLook hidden = LookAtStrip(strip, PhotoOf(Grass, south), {});
  CHECK(open.result == LookResult::kCompared);
  CHECK(hidden.compared_ratio < 0.1);
  CHECK(hidden.result == LookResult::kNotShown);
}

TEST_CASE("watch: the result does not depend on the number of threads") {
  const StripPicture strip = StoredStrip(Grass);
  const WatchedPhoto photo = PhotoOf(With(Grass, kCarPlace, kCarSize, kSilver), AboveStrip());
  const int num_threads = cv::getNumThreads();
  cv::setNumThreads(1);
  const StripLook one = LookAtStrip(strip, photo, {});
  cv::setNumThreads(4);
  const StripLook four = LookAtStrip(strip, photo, {});
  cv::setNumThreads(num_threads);
  CHECK(one.offset_in_world == four.offset_in_world);
  CHECK(one.correlation == four.correlation);
  REQUIRE(one.things.size() == four.things.size());
  REQUIRE(!one.things.empty());
  CHECK(one.things[0].place_in_world == four.things[0].place_in_world);
  CHECK(one.things[0].deviations == four.things[0].deviations);
}

TEST_CASE("watch: bad input is refused") {
  StripPicture strip = StoredStrip(Grass);
  WatchedPhoto photo = PhotoOf(Grass, AboveStrip());
  photo.image = photo.image.rowRange(1, photo.image.rows).clone();
  CHECK_THROWS_AS(LookAtStrip(strip, photo, {}), std::invalid_argument);
  photo = PhotoOf(Grass, AboveStrip());
  strip.grid.num_rows += 1;
  CHECK_THROWS_AS(LookAtStrip(strip, photo, {}), std::invalid_argument);
}

TEST_CASE("watch options: values outside their bounds are refused by name") {
  WatchOptions options;
  options.context_m = -1.0;
  CHECK_THROWS_WITH_AS(
      options.Check(), "watch.context_m = -1: must be in [0, 100]", std::invalid_argument);
  options = {};
  options.min_evidence = std::nan("");
  CHECK_THROWS_AS(options.Check(), std::invalid_argument);
  options = {};
  options.grow_deviations = 0.0;
  CHECK_THROWS_AS(options.Check(), std::invalid_argument);
  options = {};
  options.min_num_matches = 2;
  CHECK_THROWS_AS(options.Check(), std::invalid_argument);
}

}  // namespace
}  // namespace freelsd
