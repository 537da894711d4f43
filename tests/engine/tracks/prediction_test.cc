#include "engine/tracks/prediction.h"

#include <cmath>

#include <doctest/doctest.h>

#include "tests/engine/tracks/textured_plane.h"

namespace freelsd {
namespace {

constexpr double kHeightM = 100.0;

struct Exposure {
  PosedImage believed;
  Rigid3d truth;
};

// A photograph, and the pose that its autopilot tells.
Exposure Expose(const TexturedPlane& plane,
                const Eigen::Vector3d& position,
                double yaw_deg,
                const EulerAngles& error_deg = {}) {
  const Rig rig = VideoRig();
  Exposure exposure;
  exposure.truth = WorldFromCamera(rig, position, {0.0, 0.0, RadFromDeg(yaw_deg)});
  exposure.believed.image =
      WithPyramid(ReduceForTracking(plane.Photograph(rig.camera, exposure.truth), TracksOptions{}));
  exposure.believed.camera = rig.camera;
  exposure.believed.world_from_camera = WorldFromCamera(rig,
                                                        position,
                                                        {RadFromDeg(error_deg.roll),
                                                         RadFromDeg(error_deg.pitch),
                                                         RadFromDeg(yaw_deg + error_deg.yaw)});
  return exposure;
}

// Share of the corners of `from` that are found within half a pixel of where `to` shows them.
double FoundRatio(const Exposure& from, const Exposure& to) {
  const auto overlap = OverlapOverGround(from.believed, to.believed, 0.0);
  REQUIRE(overlap.has_value());
  PosedImage true_from = from.believed, true_to = to.believed;
  true_from.world_from_camera = from.truth;
  true_to.world_from_camera = to.truth;
  std::vector<Eigen::Vector2d> points, guesses, truths;
  for (const Eigen::Vector2d& corner : FindCorners(from.believed.image, {}, 300)) {
    const auto guess = TransferOverGround(from.believed, to.believed, corner, 0.0);
    const auto truth = TransferOverGround(true_from, true_to, corner, 0.0);
    if (!guess || !truth || !to.believed.camera.IsInside(*truth, 20.0)) continue;
    if (!from.believed.camera.IsInside(corner, 20.0)) continue;
    points.push_back(corner);
    guesses.push_back(*guess);
    truths.push_back(*truth);
  }
  REQUIRE(points.size() > 50);
  const auto found =
      FollowOverGround(from.believed, to.believed, *overlap, points, guesses, TracksOptions{});
  int num_found = 0;
  for (size_t i = 0; i < found.size(); ++i) {
    num_found += found[i] && (*found[i] - truths[i]).norm() < 0.5;
  }
  return num_found / static_cast<double>(found.size());
}

TEST_CASE("prediction: corners are found in a photograph of the next line, flown the other way") {
  const TexturedPlane plane(400.0);
  const Exposure from = Expose(plane, {0.0, 0.0, kHeightM}, 10.0);
  const Exposure to = Expose(plane, {40.0, 30.0, kHeightM + 8.0}, 187.0);
  CHECK(FoundRatio(from, to) > 0.9);
}

TEST_CASE("prediction: attitudes wrong by some degrees lose few corners, by 40 nearly all") {
  const TexturedPlane plane(400.0);
  const Exposure from = Expose(plane, {0.0, 0.0, kHeightM}, 0.0);
  CHECK(FoundRatio(from, Expose(plane, {0.0, 45.0, kHeightM}, 0.0, {3.0, -2.0, 4.0})) > 0.8);
  CHECK(FoundRatio(from, Expose(plane, {0.0, 45.0, kHeightM}, 0.0, {0.0, 0.0, 40.0})) < 0.3);
}

TEST_CASE("prediction: a brighter photograph is followed as well") {
  const TexturedPlane plane(400.0);
  const Exposure from = Expose(plane, {0.0, 0.0, kHeightM}, 0.0);
  Exposure to = Expose(plane, {0.0, 45.0, kHeightM}, 90.0);
  cv::Mat brighter;
  to.believed.image.grey.convertTo(brighter, CV_8U, 0.7, 60.0);
  to.believed.image = WithPyramid({brighter, 1.0});
  CHECK(FoundRatio(from, to) > 0.8);
}

TEST_CASE("prediction: the overlap is the shared ground, and nothing beyond the horizon") {
  const TexturedPlane plane(400.0);
  const Exposure from = Expose(plane, {0.0, 0.0, kHeightM}, 0.0);
  const auto overlap = [&](const Exposure& to) {
    const auto found = OverlapOverGround(from.believed, to.believed, 0.0);
    return found ? found->ratio : 0.0;
  };
  CHECK(overlap(from) > 0.95);
  // The photograph shows 103 m along the flight.
  CHECK(overlap(Expose(plane, {0.0, 51.6, kHeightM}, 0.0)) == doctest::Approx(0.5).epsilon(0.15));
  CHECK(overlap(Expose(plane, {0.0, 300.0, kHeightM}, 0.0)) == 0.0);
  CHECK_FALSE(OverlapOverGround(from.believed, from.believed, kHeightM + 5.0).has_value());
}

TEST_CASE("prediction: the attitude follows the points that were found") {
  const TexturedPlane plane(400.0);
  const Exposure from = Expose(plane, {0.0, 0.0, kHeightM}, 0.0);
  const Exposure to = Expose(plane, {0.0, 45.0, kHeightM}, 0.0, {2.0, -1.0, 3.0});
  PosedImage true_to = to.believed;
  true_to.world_from_camera = to.truth;
  std::vector<Eigen::Vector2d> expected, found;
  for (const Eigen::Vector2d& corner : FindCorners(from.believed.image, {}, 100)) {
    const auto guess = TransferOverGround(from.believed, to.believed, corner, 0.0);
    const auto truth = TransferOverGround(from.believed, true_to, corner, 0.0);
    if (!guess || !truth) continue;
    expected.push_back(*guess);
    found.push_back(*truth);
  }
  const Eigen::Quaterniond turned = TurnedToFit(to.believed, expected, found);
  CHECK(DegFromRad(AngleBetween(turned, to.truth.rotation)) < 0.05);
}

}  // namespace
}  // namespace freelsd
