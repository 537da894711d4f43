// What stands, is unseen or uncertain below an approach path, and what the path does about it.
#include <cmath>

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

constexpr double kCellM = 1.0;

TEST_CASE("approach: half the path's height is enough near touchdown, no less") {
  const double distance = ApproachDistance(Nimble(), 4.0);
  const double path_slope = 10.0 / distance;
  for (const double share : {0.40, 0.60}) {
    // Ground that rises towards the start of the final, by a share of the path's slope.
    Scene hill = scene::Meadow(240, 240, kCellM, [&](const Eigen::Vector2d& place) {
      return share * path_slope * std::clamp(-place.y(), 0.0, 15.0);
    });
    // Meadow would need no clearance.
    scene::ForCells(hill, {-120, -120}, {120, -9}, [&](int row, int col) {
      hill.hazards.hazard(row, col) = kHazard;
    });
    PlanRequest request = Request(Box({-1, -0.9}, {1, 1}), Eigen::Vector2d(0.0, -4.0));
    const Plan plan = PlanOn(hill, request, Nimble(), scene::OneWay());
    CHECK((plan.verdict == Verdict::kLandable) == (share < 0.5));
  }
}

TEST_CASE("approach: one unseen cell below the final rejects as unseen") {
  Scene meadow = FlatMeadow(240, 240);
  AddUnseen(meadow, {-120, -34}, {120, -33});
  const PlanRequest request = Request(Box({-20, -10}, {20, 10}), Eigen::Vector2d(0.0, -4.0));
  const Plan plan = PlanOn(meadow, request);
  CHECK(plan.verdict == Verdict::kRejected);
  CHECK(plan.reject_reason == RejectReason::kApproachUnseen);
  REQUIRE(plan.approach);
  int num_unseen = 0;
  for (const double height : plan.approach->profile.terrain_height)
    num_unseen += std::isnan(height);
  CHECK(num_unseen > 0);
}

TEST_CASE("approach: a height that is too uncertain is as good as unseen, but still blocks") {
  Scene meadow = FlatMeadow(240, 240);
  const PlanRequest request = Request(Box({-20, -10}, {20, 10}), Eigen::Vector2d(0.0, -4.0));
  scene::ForCells(meadow, {-120, -34}, {120, -33}, [&](int row, int col) {
    meadow.map.standard_deviation(row, col) = 3.0f;
  });
  CHECK(PlanOn(meadow, request).reject_reason == RejectReason::kApproachUnseen);
  AddBlock(meadow, {-120, -34}, {120, -33}, 20.0);
  CHECK(PlanOn(meadow, request).reject_reason == RejectReason::kApproachBlocked);
}

TEST_CASE("approach: even ground of no grass is bare, what is uneven or has holes may be a tree") {
  // The path is 6.5 m high there, 2 m of clearance are wanted, and 2 m are added to what may grow.
  Scene meadow = FlatMeadow(240, 240);
  const auto soil_at = [&](double height, double roughness) {
    Scene soil = FlatMeadow(240, 240);
    scene::ForCells(soil, {-60, -40}, {60, -20}, [&](int row, int col) {
      soil.map.elevation(row, col) = soil.map.upper(row, col) = static_cast<float>(height);
      soil.hazards.grass(row, col) = 0.1f;
      soil.hazards.hazard(row, col) = kHazard;
      soil.hazards.roughness(row, col) = static_cast<float>(roughness);
    });
    return soil;
  };
  const PlanRequest request = Request(Box({-0.9, -0.9}, {0.9, 0.9}), Eigen::Vector2d(0.0, -4.0));
  const auto reason_on = [&](const Scene& scene) {
    return PlanOn(scene, request, Nimble(), scene::OneWay()).reject_reason;
  };
  CHECK_FALSE(reason_on(soil_at(1.0, 0.2)));
  CHECK(reason_on(soil_at(1.0, 0.7)) == RejectReason::kApproachBlocked);
  Scene upper = soil_at(1.0, 0.2);
  scene::ForCells(upper, {-60, -40}, {60, -20}, [&](int row, int col) {
    if ((row + col) % 4 == 0) upper.map.upper(row, col) += 0.7f;
  });
  CHECK(reason_on(upper) == RejectReason::kApproachBlocked);
  // Beside the corridor, but within the radius of what is below it.
  Scene holes = soil_at(1.0, 0.2);
  AddUnseen(holes, {6, -30}, {8, -20});
  CHECK(reason_on(holes) == RejectReason::kApproachBlocked);
}

TEST_CASE("approach: trees and unclear cells below the path get their allowance") {
  Scene meadow = FlatMeadow(240, 240);
  const double distance = ApproachDistance(Nimble(), 4.0);
  const double row_at = 30.0;
  // Leaves 3 m of clearance by its seen height, 1 m with the allowance.
  const double seen_height = 10.0 * row_at / distance - 3.0;
  AddBlock(meadow, {-120, -row_at}, {120, -row_at + 1}, seen_height);
  PlanRequest request = Request(Box({-1, -1}, {1, 0.9}), Eigen::Vector2d(0.0, -4.0));
  CHECK(PlanOn(meadow, request).verdict == Verdict::kLandable);
  scene::ForCells(meadow, {-120, -row_at}, {120, -row_at + 1}, [&](int row, int col) {
    meadow.hazards.grass(row, col) = 0.2f;
  });
  CHECK(PlanOn(meadow, request).reject_reason == RejectReason::kApproachBlocked);
}

TEST_CASE("approach: a pole of one cell in the corridor is never stepped over") {
  PlanRequest request = Request(Box({-0.9, -0.9}, {0.9, 0.9}), std::nullopt);
  const double distance = ApproachDistance(Nimble(), 4.0);
  for (int heading_deg = 0; heading_deg < 360; heading_deg += 17) {
    for (const double lateral : {-4.9, -2.0, 0.0, 3.3, 4.9}) {
      Scene meadow = FlatMeadow(150, 150);
      const Eigen::Vector2d forward = DirectionOf(RadFromDeg(heading_deg));
      const Eigen::Vector2d right(forward.y(), -forward.x());
      const Eigen::Vector2d pole = -0.7 * distance * forward + lateral * right;
      const cv::Point cell(static_cast<int>(std::floor(pole.x() + 75.0)),
                           static_cast<int>(std::floor(75.0 - pole.y())));
      meadow.map.upper(cell) = 9.0f;
      meadow.hazards.hazard(cell) = kHazard;
      request.wind_in_world = -4.0 * forward;
      const Plan plan = PlanOn(meadow, request, Nimble(), scene::OneWay());
      // Touchdown is within a cell of the origin, so poles at the edge may be just outside.
      if (std::abs(lateral) < 4.0) CHECK(plan.reject_reason == RejectReason::kApproachBlocked);
    }
  }
}

}  // namespace
}  // namespace freelsd
