#include "engine/approach/approach.h"

#include <cmath>
#include <stdexcept>

#include <doctest/doctest.h>

#include "tests/engine/approach/scene.h"

namespace freelsd {
namespace {

using scene::AddBlock;
using scene::AddUnseen;
using scene::Box;
using scene::FlatMeadow;
using scene::Nimble;
using scene::PlanOn;
using scene::Request;
using scene::Scene;

TEST_CASE(
    "approach: a seen flat meadow is landable, into the wind, with the path's own clearance") {
  const Scene meadow = FlatMeadow(240, 240);
  const Polygon field = Box({-40, -40}, {40, 40});
  const Plan plan = PlanOn(meadow, Request(field, Eigen::Vector2d(0.0, -4.0)));
  REQUIRE(plan.verdict == Verdict::kLandable);
  CHECK_FALSE(plan.reject_reason);
  CHECK(plan.rejections.empty());
  REQUIRE(plan.approach);
  const Approach& approach = *plan.approach;
  const double distance = ApproachDistance(Nimble(), 4.0);
  CHECK(approach.approach_distance == doctest::Approx(distance));
  CHECK(approach.unseen_ratio == 0.0);
  // The lowest checked place is the edge of the touchdown disc, 8 m out.
  CHECK(approach.min_clearance == doctest::Approx(10.0 * 8.0 / distance));
  CHECK(approach.profile.distance.front() == doctest::Approx(distance));
  CHECK(approach.profile.distance.back() == 0.0);
  CHECK(approach.profile.path_height.front() == doctest::Approx(10.0));
  CHECK(approach.profile.terrain_height.front() == 0.0);
  CHECK(plan.slope == 0.0);
  CHECK(plan.roughness == 0.0);
  CHECK(plan.score > 0.8);
  CHECK(plan.score == 1.0 - plan.risk->failure_probability);
}

TEST_CASE("approach: in eight winds the aircraft starts downwind and flies into the wind") {
  const Scene meadow = FlatMeadow(240, 240);
  const Polygon field = Box({-40, -40}, {40, 40});
  for (int eighth = 0; eighth < 8; ++eighth) {
    // The wind blows towards this heading.
    const double towards_deg = 45.0 * eighth;
    const Eigen::Vector2d to(std::sin(RadFromDeg(towards_deg)), std::cos(RadFromDeg(towards_deg)));
    const Plan plan = PlanOn(meadow, Request(field, Eigen::Vector2d(4.0 * to)));
    REQUIRE(plan.approach);
    CHECK(plan.verdict == Verdict::kLandable);
    const Eigen::Vector2d start_from_touchdown =
        (plan.approach->approach_start_in_world - plan.touchdown_in_world).head<2>();
    CHECK((start_from_touchdown - plan.approach->approach_distance * to).norm() < 1e-9);
    const double heading_deg = DegFromRad(plan.approach->heading);
    CHECK(std::abs(WrapAngle(RadFromDeg(heading_deg - towards_deg - 180.0))) < 1e-9);
  }
}

TEST_CASE("approach: the circle touches the final at its start, on the side it turns to") {
  for (const double blocked_side : {-1.0, 1.0}) {
    Scene meadow = FlatMeadow(240, 240);
    // Flying north; a tower on the circle of one side, beside the start of the final.
    const double radius = LoiterRadius(Nimble(), 4.0);
    const Eigen::Vector2d tower(blocked_side * 2.0 * radius, -ApproachDistance(Nimble(), 4.0));
    AddBlock(meadow, tower.array() - 1.5, tower.array() + 1.5, 30.0);
    const Polygon field = Box({-2, -2}, {2, 2});
    PlanRequest request = Request(field, Eigen::Vector2d(0.0, -4.0));
    const Plan plan = PlanOn(meadow, request);
    REQUIRE(plan.verdict == Verdict::kLandable);
    const Approach& approach = *plan.approach;
    const LoiterDirection free_side =
        blocked_side < 0.0 ? LoiterDirection::kRight : LoiterDirection::kLeft;
    CHECK(approach.loiter_direction == free_side);
    const Eigen::Vector3d arm = approach.loiter_center_in_world - approach.approach_start_in_world;
    CHECK(arm.norm() == doctest::Approx(radius));
    CHECK(std::abs(arm.head<2>().dot(DirectionOf(approach.heading))) < 1e-9);
    // Flying north, west is left.
    CHECK((arm.x() < 0.0) == (free_side == LoiterDirection::kLeft));
    CHECK(arm.z() == 0.0);
  }
}

TEST_CASE("approach: a house below the final makes it take the next touchdown and say why") {
  Scene meadow = FlatMeadow(240, 260);
  // Two fields side by side; the eastern one is wider, but a house stands south of it.
  AddBlock(meadow, {-130, -120}, {-50, 120}, 0.0);
  AddBlock(meadow, {-8, -120}, {-2, 120}, 0.0);
  AddBlock(meadow, {70, -120}, {130, 120}, 0.0);
  AddBlock(meadow, {28, -38}, {38, -28}, 8.0);
  ApproachOptions options;
  options.max_num_candidates = 2000;
  options.max_num_rejections = 1000;
  // Touchdowns on a line across both fields, wind towards the south: flies north.
  PlanRequest request = Request(Box({-50, -1}, {70, 1}), Eigen::Vector2d(0.0, -4.0));
  const Plan plan = PlanOn(meadow, request, Nimble(), options);
  REQUIRE(plan.verdict == Verdict::kLandable);
  CHECK(std::abs(plan.touchdown_in_world.x() - 33.0) > 5.0 + 5.0);
  REQUIRE_FALSE(plan.rejections.empty());
  for (const Rejection& rejection : plan.rejections) {
    CHECK(rejection.reason == RejectReason::kApproachBlocked);
    REQUIRE(rejection.obstacle_in_world);
    CHECK(std::abs(rejection.obstacle_in_world->x() - 33.0) <= 5.0);
    CHECK(std::abs(rejection.obstacle_in_world->y() + 33.0) <= 5.0);
    CHECK(rejection.obstacle_in_world->z() == doctest::Approx(8.0));
    CHECK(rejection.detail.find("8.0 m above the touchdown point") != std::string::npos);
  }
}

TEST_CASE("approach: a tall thing below the finals of a field's middle leaves its sides") {
  Scene meadow = FlatMeadow(260, 260);
  AddBlock(meadow, {-130, -130}, {-60, 130}, 0.0);
  AddBlock(meadow, {60, -130}, {130, 130}, 0.0);
  AddBlock(meadow, {-130, 60}, {130, 130}, 0.0);
  AddBlock(meadow, {-130, -130}, {130, -60}, 0.0);
  // Flies north; the safest places are those around the origin.
  scene::ForCells(meadow, {-22, -34}, {22, -30}, [&](int row, int col) {
    meadow.map.upper(row, col) += 9.0f;
    meadow.hazards.hazard(row, col) = kHazard;
  });
  const Plan plan = PlanOn(meadow, Request(Box({-60, -60}, {60, 60}), Eigen::Vector2d(0.0, -4.0)));
  REQUIRE(plan.verdict == Verdict::kLandable);
  CHECK(plan.touchdown_in_world.head<2>().norm() > 20.0);
}

TEST_CASE("approach: a wall across the only final rejects, with its place and height") {
  Scene meadow = FlatMeadow(240, 240);
  AddBlock(meadow, {-120, 30}, {120, 32}, 6.3);  // north of the field
  const PlanRequest request = Request(Box({-40, -4}, {40, 5}), Eigen::Vector2d(0.0, 4.0));
  const Plan plan = PlanOn(meadow, request);  // flies south, over the wall
  CHECK(plan.verdict == Verdict::kRejected);
  CHECK(plan.reject_reason == RejectReason::kApproachBlocked);
  CHECK(plan.reject_detail.find("the final is blocked") == 0);
  CHECK(plan.reject_detail.find("6.3 m above the touchdown point") != std::string::npos);
  REQUIRE(plan.approach);
  CHECK(plan.approach->min_clearance < 2.0);
  REQUIRE_FALSE(plan.rejections.empty());
  CHECK(std::abs(plan.rejections[0].obstacle_in_world->y() - 31.0) < 1.5);
  CHECK(plan.score <= 0.2);
  // The other way round the same field can be landed on.
  const Plan other_way = PlanOn(meadow, Request(request.footprint, Eigen::Vector2d(0.0, -4.0)));
  CHECK(other_way.verdict == Verdict::kLandable);
}

TEST_CASE("approach: circles partly off the map leave it unverified, blocked ones reject") {
  // Touchdown and final are on the map, both circles leave it.
  Scene strip = FlatMeadow(240, 50);
  const PlanRequest request = Request(Box({-15, -10}, {15, 10}), Eigen::Vector2d(0.0, -4.0));
  const Plan plan = PlanOn(strip, request);
  CHECK(plan.verdict == Verdict::kUnverified);
  CHECK(plan.approach->unseen_ratio > 0.2);
  CHECK(plan.approach->unseen_ratio < 1.0);
  // Towers in the seen part of both.
  const double start_y = -ApproachDistance(Nimble(), 4.0);
  AddBlock(strip, {-24, start_y - 30}, {-14, start_y + 30}, 30.0);
  CHECK(PlanOn(strip, request).verdict == Verdict::kUnverified);
  AddBlock(strip, {14, start_y - 30}, {24, start_y + 30}, 30.0);
  const Plan blocked = PlanOn(strip, request, Nimble(), scene::OneWay());
  CHECK(blocked.verdict == Verdict::kRejected);
  CHECK(blocked.reject_reason == RejectReason::kLoiterBlocked);
  CHECK(blocked.reject_detail.find("both loiter circles") == 0);
}

// Woods on both sides of the final, with room for it between them; circles lie over them.
Scene BetweenWoods(double wood_height) {
  Scene meadow = FlatMeadow(400, 240);
  AddBlock(meadow, {-115, -195}, {-14, -10}, wood_height);
  AddBlock(meadow, {14, -195}, {115, -10}, wood_height);
  return meadow;
}

TEST_CASE("approach: above blocked circles a higher start of the same final is found") {
  const PlanRequest request = Request(Box({-10, 0}, {10, 20}), Eigen::Vector2d(0.0, -4.0));
  const Scene meadow = BetweenWoods(15.0);
  const Plan plan = PlanOn(meadow, request);
  REQUIRE(plan.verdict == Verdict::kLandable);
  const Approach& approach = *plan.approach;
  CHECK(approach.approach_height == doctest::Approx(2.0 * Nimble().approach_height_m));
  CHECK(approach.approach_distance == doctest::Approx(2.0 * ApproachDistance(Nimble(), 4.0)));
  CHECK(approach.approach_start_in_world.z() == doctest::Approx(approach.approach_height));
  CHECK(approach.min_clearance <= approach.approach_height - 15.0);
  REQUIRE_FALSE(plan.rejections.empty());
  CHECK(plan.rejections.front().reason == RejectReason::kLoiterBlocked);
  // Nothing higher than needed, and nothing where all are blocked.
  CHECK(PlanOn(BetweenWoods(5.0), request).approach->approach_height ==
        doctest::Approx(Nimble().approach_height_m));
  CHECK(PlanOn(BetweenWoods(29.0), request).reject_reason == RejectReason::kLoiterBlocked);
  CHECK(PlanOn(meadow, request, Nimble(), scene::OneWay()).reject_reason ==
        RejectReason::kLoiterBlocked);
}

TEST_CASE(
    "approach: where the final into the wind is blocked, one with some wind across is found") {
  Scene meadow = FlatMeadow(240, 240);
  AddBlock(meadow, {-3, -40}, {3, -34}, 12.0);
  const PlanRequest request = Request(Box({-0.9, -0.9}, {0.9, 0.9}), Eigen::Vector2d(0.0, -4.0));
  CHECK(PlanOn(meadow, request, Nimble(), scene::OneWay()).reject_reason ==
        RejectReason::kApproachBlocked);
  const Plan plan = PlanOn(meadow, request);
  REQUIRE(plan.verdict == Verdict::kLandable);
  const Aircraft aircraft = Nimble();
  const double off_deg = std::abs(DegFromRad(WrapAngle(plan.approach->heading)));
  CHECK(off_deg > 5.0);
  CHECK(plan.approach->crosswind == doctest::Approx(4.0 * std::sin(RadFromDeg(off_deg))));
  CHECK(plan.approach->crosswind <= 0.15 * aircraft.landing_airspeed_mps);
  // Eq. 1 with less of the wind from ahead: longer than into the wind, shorter than in a calm.
  CHECK(plan.approach->approach_distance > ApproachDistance(aircraft, 4.0) + 1.0);
  CHECK(plan.approach->approach_distance < ApproachDistance(aircraft, 0.0));
  REQUIRE_FALSE(plan.rejections.empty());
  CHECK(plan.rejections.front().reason == RejectReason::kApproachBlocked);
  // Too broad to be passed on that side.
  AddBlock(meadow, {-40, -40}, {40, -34}, 12.0);
  CHECK(PlanOn(meadow, request).reject_reason == RejectReason::kApproachBlocked);
}

TEST_CASE("approach: a longer final must be seen and clear to its start") {
  const PlanRequest request = Request(Box({-10, 0}, {10, 20}), Eigen::Vector2d(0.0, -4.0));
  Scene walled = BetweenWoods(15.0);
  // Below the higher start only.
  AddBlock(walled, {-14, -70}, {14, -60}, 19.0);
  CHECK(PlanOn(walled, request).reject_reason == RejectReason::kLoiterBlocked);
  Scene unseen = BetweenWoods(15.0);
  AddUnseen(unseen, {-14, -70}, {14, -60});
  CHECK(PlanOn(unseen, request).reject_reason == RejectReason::kLoiterBlocked);
}

TEST_CASE("approach: what lies behind touchdown must be free for the ground roll") {
  Scene meadow = FlatMeadow(240, 240);
  AddBlock(meadow, {-120, 18}, {120, 20}, 0.0);  // a ditch north of the field
  PlanRequest request = Request(Box({-20, 4}, {20, 8}), Eigen::Vector2d(0.0, -4.0));
  Aircraft aircraft = Nimble();
  aircraft.touchdown_uncertainty_m = 5.0;
  const Plan plan = PlanOn(meadow, request, aircraft);
  CHECK(plan.verdict == Verdict::kRejected);
  CHECK(plan.reject_reason == RejectReason::kNoSafeTouchdown);
  CHECK(plan.reject_detail.find("the ground roll meets a hazard") == 0);
  aircraft.ground_roll_m = 0.0;  // the paper's rule
  CHECK(PlanOn(meadow, request, aircraft).verdict == Verdict::kLandable);
  aircraft.ground_roll_m = 15.0;
  request.wind_in_world = Eigen::Vector2d(0.0, 4.0);  // rolls away from the ditch
  CHECK(PlanOn(meadow, request, aircraft).verdict == Verdict::kLandable);
}

TEST_CASE("approach: without wind all headings are tried and the verdict is at most unverified") {
  Scene meadow = FlatMeadow(500, 500);
  const Polygon field = Box({-20, -20}, {20, 20});
  const Plan open = PlanOn(meadow, Request(field, std::nullopt));
  CHECK(open.verdict == Verdict::kUnverified);
  CHECK(open.approach->approach_distance == doctest::Approx(ApproachDistance(Nimble(), 0.0)));
  // Walls on three sides: only the final from the west, flying east, is left.
  AddBlock(meadow, {-60, 40}, {60, 44}, 30.0);
  AddBlock(meadow, {-60, -44}, {60, -40}, 30.0);
  AddBlock(meadow, {40, -44}, {44, 44}, 30.0);
  const Plan walled = PlanOn(meadow, Request(field, std::nullopt));
  REQUIRE(walled.verdict == Verdict::kUnverified);
  CHECK(std::abs(DegFromRad(walled.approach->heading) - 90.0) < 25.0);
  // A low wall that the calm final clears, but not the one with the wind from behind.
  Scene hedge = FlatMeadow(500, 500);
  AddBlock(hedge, {-250, -250}, {-45, 250}, 4.0);
  AddBlock(hedge, {45, -250}, {250, 250}, 4.0);
  AddBlock(hedge, {-250, 45}, {250, 250}, 4.0);
  AddBlock(hedge, {-250, -250}, {250, -45}, 4.0);
  const Polygon middle = Box({-3, -3}, {3, 3});
  PlanRequest request = Request(middle, std::nullopt);
  CHECK(PlanOn(hedge, request).reject_reason == RejectReason::kApproachBlocked);
  request.wind_in_world = Eigen::Vector2d::Zero();
  CHECK(PlanOn(hedge, request).verdict == Verdict::kLandable);
}

TEST_CASE("approach: calm wind leaves the heading free and can be landable") {
  Scene meadow = FlatMeadow(400, 400);
  AddBlock(meadow, {-60, 40}, {60, 44}, 30.0);
  AddBlock(meadow, {-60, -44}, {60, -40}, 30.0);
  AddBlock(meadow, {40, -44}, {44, 44}, 30.0);
  const Plan plan = PlanOn(meadow, Request(Box({-20, -20}, {20, 20}), Eigen::Vector2d(0.1, 0.1)));
  REQUIRE(plan.verdict == Verdict::kLandable);
  CHECK(std::abs(DegFromRad(plan.approach->heading) - 90.0) < 25.0);
}

TEST_CASE("approach: too strong a wind has no approach and says so") {
  const Plan plan =
      PlanOn(FlatMeadow(240, 240), Request(Box({-40, -40}, {40, 40}), Eigen::Vector2d(15.0, 0.0)));
  CHECK(plan.verdict == Verdict::kRejected);
  CHECK(plan.reject_reason == RejectReason::kWindTooStrong);
  CHECK_FALSE(plan.approach);
  CHECK(plan.hazard_distance > 50.0);
}

TEST_CASE("approach: every reason against the region itself is told apart") {
  const Scene meadow = FlatMeadow(240, 240);
  const PlanRequest good = Request(Box({-40, -40}, {40, 40}), Eigen::Vector2d(0.0, -4.0));
  const auto reason_for = [&](const auto& change) {
    PlanRequest request = good;
    change(request);
    const Plan plan = PlanOn(meadow, request);
    CHECK(plan.verdict == Verdict::kRejected);
    CHECK_FALSE(plan.reject_detail.empty());
    return plan.reject_reason;
  };
  CHECK(reason_for([](PlanRequest& r) { r.area_m2 = 899.0; }) == RejectReason::kTooSmall);
  CHECK(reason_for([](PlanRequest& r) { r.area_m2 = NAN; }) == RejectReason::kTooSmall);
  CHECK(reason_for([](PlanRequest& r) { r.num_observations = 1; }) ==
        RejectReason::kTooFewObservations);
  CHECK(reason_for([](PlanRequest& r) { r.grade = 0.0; }) == RejectReason::kNotGrass);
  CHECK(reason_for([](PlanRequest& r) {
          r.footprint = Box({500, 0}, {600, 50});
        }) == RejectReason::kNoTerrain);
  CHECK(reason_for([](PlanRequest& r) { r.footprint.clear(); }) == RejectReason::kNoTerrain);

  Scene asphalt = FlatMeadow(240, 240);
  asphalt.hazards.grass.setTo(0.1f);
  asphalt.hazards.hazard.setTo(uchar{kHazard});
  scene::UpdateDistance(asphalt);
  CHECK(PlanOn(asphalt, good).reject_reason == RejectReason::kNotGrass);

  Scene narrow = FlatMeadow(240, 240);
  AddBlock(narrow, {-120, 5}, {120, 6}, 0.0);
  AddBlock(narrow, {-120, -12}, {120, -11}, 0.0);
  PlanRequest request = good;
  request.footprint = Box({-40, -11}, {40, 5});
  const Plan plan = PlanOn(narrow, request);
  CHECK(plan.reject_reason == RejectReason::kNoSafeTouchdown);
  CHECK(plan.hazard_distance > 7.0);
  CHECK(std::abs(plan.touchdown_in_world.y() + 3.0) <= 1.0);  // least bad: the middle
}

TEST_CASE("approach: a region that was not seen is answered at its own height") {
  Scene unseen = FlatMeadow(100, 100);
  AddUnseen(unseen, {-50, -50}, {50, 50});
  PlanRequest request = Request(Box({-20, -20}, {20, 20}), Eigen::Vector2d(0.0, -4.0));
  request.ground_height = 12.5;
  const Plan plan = PlanOn(unseen, request);
  CHECK(plan.reject_reason == RejectReason::kNoTerrain);
  CHECK((plan.touchdown_in_world - Eigen::Vector3d(0, 0, 12.5)).norm() < 1e-9);
  CHECK(std::isnan(plan.slope));
  CHECK(plan.hazard_distance == 0.0);
  CHECK(std::isfinite(plan.score));
}

TEST_CASE("approach: an empty map and layers of another grid are an answer and a failure") {
  const PlanRequest request = Request(Box({-20, -20}, {20, 20}), Eigen::Vector2d(0.0, -4.0));
  CHECK(PlanOn(Scene{}, request).reject_reason == RejectReason::kNoTerrain);
  Scene mixed = FlatMeadow(100, 100);
  mixed.hazards = FlatMeadow(100, 101).hazards;
  CHECK_THROWS_AS(PlanOn(mixed, request), std::invalid_argument);
}

}  // namespace
}  // namespace freelsd
