#include "engine/tracks/attitude/planar_alignment.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <doctest/doctest.h>

#include "engine/flight/flight.h"
#include "engine/tracks/attitude/attitude_check.h"

namespace freelsd {
namespace {

constexpr double kHeightM = 90.0;

// Row of photographs flown east with crab, tilted at random.
struct Row {
  std::vector<Rigid3d> world_from_camera;
  std::vector<AlignmentFrame> frames;
  std::vector<AlignmentPair> pairs;
};

Eigen::Vector2d Seen(const Rigid3d& world_from_camera, const Eigen::Vector3d& point) {
  return (Inverse(world_from_camera) * point).hnormalized();
}

// Compilers differ in the order in which arguments are made: each draw stands alone.
Row FlyRow(
    int count, double spacing_m, double gps_sd_m, double tilt_sd_deg = 6.0, unsigned seed = 7) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal;
  const Rigid3d mount = Rig{}.body_from_camera;
  Row row;
  for (int i = 0; i < count; ++i) {
    const EulerAngles attitude{RadFromDeg(tilt_sd_deg * normal(generator)),
                               RadFromDeg(tilt_sd_deg * normal(generator)),
                               RadFromDeg(50.0)};
    const double up_m = kHeightM + 2.0 * normal(generator);
    const double aside_m = 3.0 * normal(generator);
    const Eigen::Vector3d position(spacing_m * i, aside_m, up_m);
    row.world_from_camera.push_back(Rigid3d{WorldFromNed() * NedFromBody(attitude), position} *
                                    mount);
    AlignmentFrame frame;
    const double north = normal(generator);
    const double east = normal(generator);
    frame.position_in_world = position + gps_sd_m * Eigen::Vector3d(east, north, 0.0);
    frame.position_sd_m = std::max(gps_sd_m, 0.5);
    row.frames.push_back(frame);
  }
  std::uniform_real_distribution<double> spread(-40.0, 40.0);
  for (int i = 1; i < count; ++i) {
    AlignmentPair pair;
    pair.a = static_cast<size_t>(i - 1);
    pair.b = static_cast<size_t>(i);
    for (int k = 0; k < 60; ++k) {
      const double up_m = normal(generator);
      const double north_m = spread(generator);
      const double east_m = spacing_m * (i - 0.5) + spread(generator);
      const Eigen::Vector3d point(east_m, north_m, up_m);
      pair.points_a.push_back(Seen(row.world_from_camera[i - 1], point));
      pair.points_b.push_back(Seen(row.world_from_camera[i], point));
    }
    row.pairs.push_back(pair);
  }
  return row;
}

const AlignmentOptions kOptions{.nadir_sd = RadFromDeg(8.0), .max_heading_sd = RadFromDeg(15.0)};

std::vector<double> ErrorsDeg(const Row& row, const std::vector<AlignmentFrame>& solved) {
  std::vector<double> errors;
  for (size_t i = 0; i < solved.size(); ++i) {
    errors.push_back(
        DegFromRad(AngleBetween(solved[i].world_from_camera, row.world_from_camera[i].rotation)));
  }
  return errors;
}

double Median(std::vector<double> errors) {
  const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
  std::nth_element(errors.begin(), middle, errors.end());
  return *middle;
}

TEST_CASE("planar alignment: tilted, crabbing photographs get their attitude within 3 degrees") {
  constexpr double kMaxErrorDeg = 3.0;
  constexpr double kMaxHeightErrorM = 6.0;
  std::vector<double> errors_deg;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const Row row = FlyRow(8, 35.0, 1.5, 6.0, seed);
    const auto of_row = ErrorsDeg(row, AlignToGround(row.frames, row.pairs, kOptions));
    errors_deg.insert(errors_deg.end(), of_row.begin(), of_row.end());
  }
  CHECK(Median(errors_deg) < kMaxErrorDeg);
  const Row row = FlyRow(8, 35.0, 1.5);
  const std::vector<AlignmentFrame> solved = AlignToGround(row.frames, row.pairs, kOptions);
  for (size_t i = 0; i < solved.size(); ++i) {
    CHECK(solved[i].is_solved);
    CHECK(std::abs(solved[i].height_above_ground - row.world_from_camera[i].translation.z()) <
          kMaxHeightErrorM);
  }
}

TEST_CASE("planar alignment: a third of wrong matches does not matter much") {
  constexpr double kMaxErrorDeg = 5.0;
  Row row = FlyRow(8, 35.0, 1.5);
  for (AlignmentPair& pair : row.pairs) {
    for (size_t k = 0; k + 1 < pair.points_a.size(); k += 6) {
      std::swap(pair.points_a[k], pair.points_a[k + 1]);
    }
  }
  CHECK(Median(ErrorsDeg(row, AlignToGround(row.frames, row.pairs, kOptions))) < kMaxErrorDeg);
}

TEST_CASE("planar alignment: a frame beside a held one takes over its truth") {
  constexpr double kMaxErrorDeg = 2.5;
  Row row = FlyRow(2, 35.0, 0.0);
  row.frames[0].is_held = true;
  row.frames[0].world_from_camera = row.world_from_camera[0].rotation;
  row.frames[0].height_above_ground = row.world_from_camera[0].translation.z();
  const std::vector<AlignmentFrame> solved = AlignToGround(row.frames, row.pairs, kOptions);
  REQUIRE(solved[1].is_solved);
  CHECK(DegFromRad(AngleBetween(solved[1].world_from_camera, row.world_from_camera[1].rotation)) <
        kMaxErrorDeg);
}

TEST_CASE("planar alignment: frames at one place tell no heading and no height") {
  Row row = FlyRow(4, 0.0, 0.0);
  for (AlignmentFrame& frame : row.frames) {
    frame.position_in_world = Eigen::Vector3d(0.0, 0.0, kHeightM);
    frame.position_sd_m = 2.0;
  }
  for (const AlignmentFrame& frame : AlignToGround(row.frames, row.pairs, kOptions)) {
    CHECK(!frame.is_solved);
  }
}

TEST_CASE("planar alignment: without pairs nothing is solved") {
  const Row row = FlyRow(2, 30.0, 0.0);
  CHECK(!AlignToGround(row.frames, {}, kOptions)[0].is_solved);
}

TEST_CASE("attitude check: the frame against its GPS baseline is the one that is wrong") {
  constexpr double kToleranceDeg = 12.0;
  const Row row = FlyRow(2, 35.0, 0.5, 1.0);
  const Eigen::Quaterniond half_turn(Eigen::AngleAxisd(kPi, Eigen::Vector3d::UnitZ()));
  for (const size_t wrong : {0, 1}) {
    OrientedFrame oriented[2];
    for (size_t i = 0; i < 2; ++i) {
      oriented[i] = {
          row.frames[i].position_in_world, 0.5, row.world_from_camera[i].rotation, RadFromDeg(2.0)};
    }
    oriented[wrong].world_from_camera = oriented[wrong].world_from_camera * half_turn;
    const auto evidence = CompareAttitudes(oriented[0], oriented[1], row.pairs[0]);
    REQUIRE(evidence);
    REQUIRE(evidence->turn_of_a);
    REQUIRE(evidence->turn_of_b);
    const double right = wrong == 0 ? *evidence->turn_of_b : *evidence->turn_of_a;
    const double turned = wrong == 0 ? *evidence->turn_of_a : *evidence->turn_of_b;
    CHECK(std::abs(DegFromRad(right)) < kToleranceDeg);
    CHECK(std::abs(std::abs(DegFromRad(turned)) - 180.0) < kToleranceDeg);
  }
}

}  // namespace
}  // namespace freelsd
