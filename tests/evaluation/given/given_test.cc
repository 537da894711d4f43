#include <set>
#include <stdexcept>

#include <doctest/doctest.h>

#include "tests/evaluation/given/given_run.h"
#include "tests/evaluation/given/true_poses.h"

namespace freelsd {
namespace {

constexpr double kMaxErrorM = 1e-3;

Scenario ThreeExposures() {
  ScenarioOptions options;
  options.world_size_m = 200.0;
  options.cell_size_m = 0.5;
  options.num_frames = 3;
  options.takes_photographs = false;
  return MakeScenario(1002, options, [](double) {});
}

TEST_CASE("given: with true poses a block that is moved and turned is where it belongs") {
  const Scenario scenario = ThreeExposures();
  const Rigid3d moved_from_true{
      Eigen::Quaterniond(Eigen::AngleAxisd(0.01, Eigen::Vector3d::UnitX())), {1.0, -2.0, 3.0}};
  const Eigen::Vector3d point_in_world(2.0, 5.0, 0.0);
  AdjustedBlock block;
  block.camera = scenario.rig.camera;
  block.is_usable = true;
  block.tilt_sd_deg = 0.5;
  block.landmarks.push_back({.point_in_world = moved_from_true * point_in_world, .num_views = 3});
  for (size_t i = 0; i < scenario.exposures.size(); ++i) {
    AdjustedView view;
    view.frame_id = scenario.exposures[i].image;
    view.world_from_camera = moved_from_true * scenario.TrueWorldFromCamera(i);
    view.is_connected = true;
    view.landmarks = {0};
    block.views.push_back(view);
  }
  const AdjustedBlock with_true_poses = WithTruePoses(block, scenario);
  for (size_t i = 0; i < scenario.exposures.size(); ++i) {
    CHECK((with_true_poses.views[i].world_from_camera.translation -
           scenario.TrueWorldFromCamera(i).translation)
              .norm() < kMaxErrorM);
  }
  CHECK((with_true_poses.landmarks[0].point_in_world - point_in_world).norm() < kMaxErrorM);
  CHECK(with_true_poses.tilt_sd_deg == 0.0);
}

TEST_CASE("given: what is given has a name, and nothing else has") {
  const Given given = Given::Of({"poses", "wind"});
  CHECK(given.poses);
  CHECK(given.wind);
  CHECK_FALSE(given.kinds);
  CHECK_FALSE(given.heights);
  CHECK_THROWS_AS(Given::Of({"everything"}), std::invalid_argument);
}

TEST_CASE("flight: mixed spacings go hand in hand with neither aircraft nor window of ground") {
  ScenarioOptions options;
  options.frame_spacing_m = std::nullopt;
  int num_pairs_apart = 0;
  for (uint64_t first = 6000; first < 6120; first += 6) {
    std::set<double> of_even, of_odd;
    for (uint64_t seed = first; seed < first + 6; seed += 2) {
      of_even.insert(SpacingFor(seed, options));
      of_odd.insert(SpacingFor(seed + 1, options));
      num_pairs_apart += SpacingFor(seed, options) != SpacingFor(seed + 1, options);
    }
    CHECK(of_even.size() == kSpacingsM.size());
    CHECK(of_odd.size() == kSpacingsM.size());
  }
  // Two seeds share a window. Two thirds of 60 pairs differ where chance decides.
  CHECK(num_pairs_apart >= 20);
  CHECK(num_pairs_apart <= 55);
  CHECK(NumFramesAt(30.0) == 50);
  CHECK(NumFramesAt(13.0) == 72);
  CHECK(NumFramesAt(6.0) == 156);
}

}  // namespace
}  // namespace freelsd
