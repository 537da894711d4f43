#include "engine/next_look/next_look.h"

#include <functional>
#include <limits>
#include <stdexcept>
#include <string>

#include <doctest/doctest.h>

#include "tests/engine/approach/scene.h"
#include "tests/engine/refusal.h"
#include "tests/engine/tracks/textured_plane.h"

namespace freelsd {
namespace {

constexpr double kHeightM = 100.0;
constexpr uint8_t kOften = 6;

const Eigen::Quaterniond kLookingUp = Eigen::Quaterniond::Identity();
const Eigen::Quaterniond kLookingDown(0.0, 1.0, 0.0, 0.0);

// A half-finished flight over a scene, from south to north along x = 0. The camera looks up, so
// that no photograph has shown what is unseen.
struct HalfFlight {
  scene::Scene ground;
  cv::Mat1b num_views;
  std::vector<SiteSoFar> sites;
  Rig rig = VideoRig();
  std::vector<Rigid3d> flown;
  Aircraft aircraft = scene::Nimble();
  NextLookOptions options;

  explicit HalfFlight(scene::Scene seen) : ground(std::move(seen)) {
    num_views = cv::Mat1b(ground.map.elevation.size(), kOften);
    num_views.setTo(0, ground.hazards.hazard == kUnseen);
    for (double north = -90.0; north <= 90.0; north += 30.0) {
      flown.push_back({kLookingUp, {0.0, north, kHeightM}});
    }
    options.num_legs = 1;
    options.min_shared_ratio = 0.0;
    options.leg_length_m = 150.0;
  }

  NextLook Choose(
      const std::optional<Box>& area = std::nullopt,
      const std::function<void()>& before_leg = [] {}) const {
    return ChooseNextLook({.map = ground.map,
                           .layers = ground.hazards,
                           .num_views = num_views,
                           .sites = sites,
                           .rig = rig,
                           .flown = flown,
                           .aircraft = aircraft,
                           .wind_in_world = Eigen::Vector2d(0.0, -3.0),
                           .area = area,
                           .before_leg = before_leg},
                          options);
  }
};

Eigen::Vector2d MiddleOf(const LookLeg& leg) {
  return 0.5 * (leg.from_in_world + leg.to_in_world).head<2>();
}

// Every square of the seen part has its landing.
void FillWithLandableSites(HalfFlight& flight, const Box& box) {
  for (double east = box.min.x(); east < box.max.x(); east += 20.0) {
    for (double north = box.min.y(); north < box.max.y(); north += 20.0) {
      flight.sites.push_back({Verdict::kLandable, {east, north, 0.0}});
    }
  }
}

Box BoxOf(const Eigen::Vector2d& min, const Eigen::Vector2d& max) {
  Box box;
  box.Add(min);
  box.Add(max);
  return box;
}

TEST_CASE("next look: the leg goes where the meadow goes on, not where the wood does") {
  // Seen is the middle third: wood in the west, meadow in the east.
  HalfFlight flight = [] {
    scene::Scene ground = scene::FlatMeadow(300, 600);
    scene::AddBlock(ground, {-100.0, -150.0}, {0.0, 150.0}, 15.0);
    scene::AddUnseen(ground, {-300.0, -150.0}, {-100.0, 150.0});
    scene::AddUnseen(ground, {100.0, -150.0}, {300.0, 150.0});
    return HalfFlight(std::move(ground));
  }();
  FillWithLandableSites(flight, BoxOf({0.0, -150.0}, {100.0, 150.0}));
  const NextLook look = flight.Choose();
  REQUIRE(look.legs.size() == 1);
  CHECK(MiddleOf(look.legs.front()).x() > 60.0);
  CHECK(look.legs.front().expected_gain > 0.5);
  REQUIRE_FALSE(look.legs.front().places.empty());
  for (const LookedPlace& place : look.legs.front().places) {
    CHECK_FALSE(place.site);
    CHECK(place.touchdown_in_world.x() > 20.0);
  }
}

TEST_CASE("next look: a search that nobody wants any more stops before the next leg") {
  HalfFlight flight = [] {
    scene::Scene ground = scene::FlatMeadow(300, 300);
    scene::AddUnseen(ground, {50.0, -150.0}, {150.0, 150.0});
    return HalfFlight(std::move(ground));
  }();
  int num_legs = 0;
  CHECK_THROWS_AS(flight.Choose(std::nullopt,
                                [&num_legs] {
                                  if (++num_legs == 3) throw std::runtime_error("nobody waits");
                                }),
                  std::runtime_error);
  CHECK(num_legs == 3);
}

TEST_CASE("next look: an unverified site whose circle is unseen is told with the leg over it") {
  HalfFlight flight = [] {
    scene::Scene ground = scene::FlatMeadow(300, 300);
    scene::AddUnseen(ground, {-150.0, -150.0}, {150.0, -100.0});
    scene::AddUnseen(ground, {60.0, -150.0}, {150.0, 150.0});
    return HalfFlight(std::move(ground));
  }();
  FillWithLandableSites(flight, BoxOf({-400.0, -400.0}, {400.0, 400.0}));
  std::erase_if(flight.sites, [](const SiteSoFar& site) {
    return site.touchdown_in_world.x() >= 0.0 && site.touchdown_in_world.x() < 60.0 &&
           site.touchdown_in_world.y() >= 0.0 && site.touchdown_in_world.y() < 60.0;
  });
  PlannedLanding landing;
  landing.touchdown_in_world = {50.0, 30.0, 0.0};
  landing.approach_height = 12.0;
  landing.loiter_center_in_world = {80.0, 0.0};
  landing.loiter_radius = 30.0;
  flight.sites.push_back({Verdict::kUnverified, landing.touchdown_in_world, landing});
  const NextLook look = flight.Choose();
  REQUIRE(look.legs.size() == 1);
  REQUIRE(look.legs.front().places.size() == 1);
  CHECK(look.legs.front().places.front().site == flight.sites.size() - 1);
  // The meadow around it lets expect a free circle: half the value of a landing is to be gained.
  CHECK(look.legs.front().expected_gain > 0.25);
  CHECK(look.legs.front().expected_gain <= 0.5);
}

TEST_CASE("next look: what many photographs did not make known promises less") {
  const auto gain_with = [](const Eigen::Quaterniond& rotation) {
    HalfFlight flight = [] {
      scene::Scene ground = scene::FlatMeadow(300, 300);
      scene::AddUnseen(ground, {-60.0, -60.0}, {60.0, 60.0});
      return HalfFlight(std::move(ground));
    }();
    for (Rigid3d& pose : flight.flown) pose.rotation = rotation;
    FillWithLandableSites(flight, BoxOf({-400.0, -400.0}, {400.0, 400.0}));
    std::erase_if(flight.sites, [](const SiteSoFar& site) {
      return site.touchdown_in_world.head<2>().cwiseAbs().maxCoeff() < 60.0;
    });
    return flight.Choose().expected_gain;
  };
  CHECK(gain_with(kLookingUp) > 0.5);
  CHECK(gain_with(kLookingDown) < 0.3 * gain_with(kLookingUp));
}

TEST_CASE("next look: a leg shares ground with the photographs so far") {
  HalfFlight flight = [] {
    scene::Scene ground = scene::FlatMeadow(300, 800);
    scene::AddUnseen(ground, {80.0, -150.0}, {400.0, 150.0});
    scene::AddUnseen(ground, {-400.0, -150.0}, {-80.0, 150.0});
    return HalfFlight(std::move(ground));
  }();
  for (Rigid3d& pose : flight.flown) pose.rotation = kLookingDown;
  FillWithLandableSites(flight, BoxOf({-160.0, -400.0}, {160.0, 400.0}));
  const auto farthest = [&flight](double min_shared_ratio) {
    flight.options.min_shared_ratio = min_shared_ratio;
    return std::abs(MiddleOf(flight.Choose().legs.at(0)).x());
  };
  CHECK(farthest(0.0) > 200.0);
  CHECK(farthest(0.2) < 160.0);
}

TEST_CASE("next look: where everything is known there is nothing to fly") {
  HalfFlight flight(scene::FlatMeadow(200, 200));
  FillWithLandableSites(flight, BoxOf({-100.0, -100.0}, {100.0, 100.0}));
  flight.options.max_outside_m = 0.0;
  flight.options.leg_length_m = 60.0;
  FillWithLandableSites(flight, BoxOf({-400.0, -400.0}, {400.0, 400.0}));
  CHECK(flight.Choose().legs.empty());
}

TEST_CASE("next look: a refusal by few views, or for a doubtful kind, is worth a look") {
  const auto gain_at = [](uint8_t num_views, float grass) {
    HalfFlight flight(scene::FlatMeadow(300, 300));
    FillWithLandableSites(flight, BoxOf({-400.0, -400.0}, {400.0, 400.0}));
    std::erase_if(flight.sites, [](const SiteSoFar& site) {
      return site.touchdown_in_world.head<2>().cwiseAbs().maxCoeff() < 60.0;
    });
    scene::ForCells(flight.ground, {-60.0, -60.0}, {60.0, 60.0}, [&](int row, int col) {
      flight.ground.hazards.hazard(row, col) = kHazard;
      flight.ground.hazards.grass(row, col) = grass;
      flight.num_views(row, col) = num_views;
    });
    scene::UpdateDistance(flight.ground);
    return flight.Choose().expected_gain;
  };
  CHECK(gain_at(kOften, 0.0f) == 0.0);
  CHECK(gain_at(1, 0.0f) > 0.1);
  // Of a hazard because of its kind alone, the posterior of grass may be nearly high enough.
  CHECK(gain_at(kOften, 0.7f) > 0.1);
  CHECK(gain_at(kOften, 0.2f) == 0.0);
}

TEST_CASE("next look: both legs lie in the area, in an order that the aircraft can turn") {
  HalfFlight flight = [] {
    scene::Scene ground = scene::FlatMeadow(400, 400);
    scene::AddUnseen(ground, {50.0, -200.0}, {200.0, 200.0});
    scene::AddUnseen(ground, {-200.0, -200.0}, {-50.0, 200.0});
    return HalfFlight(std::move(ground));
  }();
  flight.options.num_legs = 2;
  const Box area = BoxOf({-190.0, -190.0}, {190.0, 190.0});
  const NextLook look = flight.Choose(area);
  REQUIRE(look.legs.size() == 2);
  Eigen::Vector2d aircraft(0.0, 90.0);
  for (const LookLeg& leg : look.legs) {
    for (const Eigen::Vector3d& end : {leg.from_in_world, leg.to_in_world}) {
      CHECK(area.DistanceTo(end.head<2>()) == 0.0);
      CHECK(end.z() == doctest::Approx(kHeightM));
    }
    CHECK((leg.to_in_world - leg.from_in_world).norm() == doctest::Approx(150.0));
    CHECK(leg.heading ==
          doctest::Approx(HeadingOf((leg.to_in_world - leg.from_in_world).head<2>())));
    CHECK(leg.transit_m >= (leg.from_in_world.head<2>() - aircraft).norm() - 1e-6);
    aircraft = leg.to_in_world.head<2>();
  }
  CHECK(look.turn_radius_m == doctest::Approx(LoiterRadius(flight.aircraft, 3.0)));
  CHECK(look.photo_spacing_m == doctest::Approx(30.0));
  CHECK(look.expected_gain ==
        doctest::Approx(look.legs[0].expected_gain + look.legs[1].expected_gain));
  // The second leg looks at the other side, or at what the first one left.
  CHECK((MiddleOf(look.legs[0]) - MiddleOf(look.legs[1])).norm() > 50.0);
}

TEST_CASE("next look: legs stay clear of what stands under them") {
  HalfFlight flight = [] {
    scene::Scene ground = scene::FlatMeadow(300, 300);
    scene::AddBlock(ground, {70.0, -150.0}, {80.0, 150.0}, 90.0);
    scene::AddUnseen(ground, {80.0, -150.0}, {150.0, 150.0});
    return HalfFlight(std::move(ground));
  }();
  const NextLook look = flight.Choose(BoxOf({60.0, -150.0}, {110.0, 150.0}));
  REQUIRE(look.legs.size() == 1);
  CHECK(look.legs.front().from_in_world.z() >= 90.0 + flight.options.min_clearance_m);
}

TEST_CASE("next look: the same request gives the same answer") {
  HalfFlight flight(scene::FlatMeadow(200, 200));
  const NextLook one = flight.Choose(), two = flight.Choose();
  REQUIRE_FALSE(one.legs.empty());
  CHECK(one.legs.front().from_in_world == two.legs.front().from_in_world);
  CHECK(one.expected_gain == two.expected_gain);
}

TEST_CASE("next look: what cannot be asked is refused") {
  HalfFlight nothing_flown(scene::FlatMeadow(50, 50));
  nothing_flown.flown.clear();
  CHECK_THROWS_AS(nothing_flown.Choose(), std::invalid_argument);
  HalfFlight other_grid(scene::FlatMeadow(50, 50));
  other_grid.ground.hazards.grid.num_cols = 49;
  CHECK_THROWS_AS(other_grid.Choose(), std::invalid_argument);
  HalfFlight nothing_seen([] {
    scene::Scene ground = scene::FlatMeadow(50, 50);
    scene::AddUnseen(ground, {-25.0, -25.0}, {25.0, 25.0});
    return ground;
  }());
  CHECK_THROWS_AS(nothing_seen.Choose(), std::invalid_argument);
}

TEST_CASE("next look: options out of bounds are named") {
  using O = NextLookOptions;
  CHECK_NOTHROW(O().Check());
  CHECK(RefusalOf(&O::num_legs, 0) == "next_look.num_legs = 0: must be in [1, 8]");
  CHECK(IsRefused(&O::leg_length_m, 10.0, "leg_length_m"));
  CHECK(IsRefused(&O::unverified_value, 1.5, "unverified"));
  CHECK(IsRefused(&O::missing_exponent, 0.0, "missing"));
}

}  // namespace
}  // namespace freelsd
