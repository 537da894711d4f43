// Places that are known from looking at the orthophotos, and heights read from the files.
#include "tests/synthetic/ground/real_ground.h"

#include <cmath>
#include <cstdlib>
#include <stdexcept>

#include <doctest/doctest.h>

#include "tests/synthetic/truth.h"

namespace freelsd {
namespace {

constexpr double kCellM = 0.2;

bool HasData() {
  if (std::getenv("FREELSD_DATA") != nullptr) return true;
  MESSAGE("skipped: FREELSD_DATA is not set");
  return false;
}

// A pixel of the orthophoto in a world whose middle is the pack's, north up.
Eigen::Vector2d PlaceOf(const RealGround& pack, double col, double row) {
  return pack.cell_size_m *
         Eigen::Vector2d(col - 0.5 * (pack.surface.cols - 1), 0.5 * (pack.surface.rows - 1) - row);
}

World WorldOf(const RealGround& pack, const Placement& placement = {}) {
  WorldOptions options;
  options.size_m = 260.0;
  options.cell_size_m = kCellM;
  return MakeWorldAround(pack, placement, options);
}

GroundFault FaultAt(const World& world, const Eigen::Vector2d& place) {
  return GroundFaultAt(world, *AircraftProfile("small"), place.x(), place.y(), 1.0);
}

TEST_CASE("real ground: heights are those of the surface model, and crowns and roofs stand on it") {
  if (!HasData()) return;
  constexpr double kMaxErrorM = 0.02;
  const RealGround pack = ReadRealGround("honduras_pool");
  const World world = WorldOf(pack);
  struct Height {
    double col, row, height_m;
  };
  // As gdallocationinfo reads them from the file: a roof, the field with the circle, the terrace.
  for (const Height& read :
       {Height{660, 520, 1111.337}, {775, 680, 1107.555}, {550, 200, 1088.270}}) {
    const Eigen::Vector2d place = PlaceOf(pack, read.col, read.row);
    const double height = world.SurfaceHeight(place.x(), place.y()) + pack.datum_m;
    CHECK(std::abs(height - read.height_m) < kMaxErrorM);
  }
  const auto standing = [&](double col, double row) {
    const Eigen::Vector2d place = PlaceOf(pack, col, row);
    return world.SurfaceHeight(place.x(), place.y()) - world.GroundHeight(place.x(), place.y());
  };
  CHECK(standing(660, 520) > 2.5);  // roof
  CHECK(standing(590, 310) > 2.5);  // crown
  CHECK(standing(775, 680) < 0.3);  // field
  CHECK(standing(550, 200) < 0.3);  // terrace
}

TEST_CASE("real ground: pool, roof, road and what surrounds the pack are no ground to land on") {
  if (!HasData()) return;
  const RealGround pack = ReadRealGround("honduras_pool");
  const World world = WorldOf(pack);
  CHECK(FaultAt(world, PlaceOf(pack, 340, 200)) == GroundFault::kCover);  // pool
  CHECK(world.CoverAt(PlaceOf(pack, 340, 200).x(), PlaceOf(pack, 340, 200).y()) == Cover::kWater);
  CHECK(FaultAt(world, PlaceOf(pack, 660, 520)) == GroundFault::kCover);  // roof
  CHECK(FaultAt(world, PlaceOf(pack, 780, 170)) == GroundFault::kCover);  // drive
  CHECK(FaultAt(world, PlaceOf(pack, 400, 480)) == GroundFault::kCover);  // bare soil
  CHECK(FaultAt(world, PlaceOf(pack, 740, 680)) == GroundFault::kNone);   // field
  // The terrace is in doubt.
  CHECK(world.CoverAt(PlaceOf(pack, 550, 200).x(), PlaceOf(pack, 550, 200).y()) == Cover::kDoubt);
  const cv::Mat1b is_meadow = world.cover == static_cast<int>(Cover::kMeadow);
  CHECK(cv::countNonZero(is_meadow) > 0);
  CHECK(cv::countNonZero(is_meadow & (world.photographed == 0)) == 0);
}

TEST_CASE("real ground: north is up and east is right, as placed and turned") {
  if (!HasData()) return;
  const RealGround pack = ReadRealGround("honduras_pool");
  // Of the pixels around a place: the pool is the one thing of its blue.
  const auto is_pool = [](const World& world, const Eigen::Vector2d& place) {
    const cv::Vec3b color = world.radiance(world.CellIndex(place.y()), world.CellIndex(place.x()));
    return color[0] > color[2] + 60;
  };
  const Eigen::Vector2d pool = PlaceOf(pack, 340, 200);
  CHECK(pool.x() < -20.0);
  CHECK(pool.y() > 30.0);
  const World upright = WorldOf(pack);
  CHECK(is_pool(upright, pool));
  CHECK(!is_pool(upright, {-pool.x(), pool.y()}));
  CHECK(!is_pool(upright, {pool.x(), -pool.y()}));
  // Its north points east: what was in the north-west is in the north-east.
  const Placement turned{{5.0, -8.0}, 0.5 * kPi};
  CHECK(is_pool(WorldOf(pack, turned), {5.0 + pool.y(), -8.0 - pool.x()}));
}

TEST_CASE("real ground: slope, boulders and bushes of a lawn are not to land on") {
  if (!HasData()) return;
  const RealGround pack = ReadRealGround("brighton_beach");
  const World world = WorldOf(pack);
  CHECK(FaultAt(world, PlaceOf(pack, 420, 480)) == GroundFault::kNone);  // lawn
  // Over 9 m it falls by 0.87 m eastwards and 0.97 m southwards: 8.3 degrees.
  CHECK(FaultAt(world, PlaceOf(pack, 220, 620)) == GroundFault::kSteep);
  CHECK(FaultAt(world, PlaceOf(pack, 226, 470)) == GroundFault::kCover);  // boulder
  CHECK(FaultAt(world, PlaceOf(pack, 346, 420)) == GroundFault::kCover);  // bush
  CHECK(FaultAt(world, PlaceOf(pack, 405, 615)) == GroundFault::kCover);  // pavilion
  CHECK(FaultAt(world, PlaceOf(pack, 480, 420)) == GroundFault::kCover);  // road
}

TEST_CASE("real ground: every pack of the pools has outlines and windows") {
  for (const char* pack : {"honduras_pool",
                           "brighton_beach",
                           "churo_pe",
                           "autzen_or",
                           "iquitos_pe",
                           "huayllapata_pe",
                           "coyotes_mx",
                           "huacayccancha_pe",
                           "ohuay_pe",
                           "centro_fuerte_pe"}) {
    CHECK_MESSAGE(!ReadGroundWindows(pack).empty(), pack);
  }
}

TEST_CASE("real ground: a seed places the pack in its own way, and a missing pack is named") {
  CHECK(PlacementFor(500).heading == PlacementFor(500).heading);
  CHECK(PlacementFor(500).heading != PlacementFor(501).heading);
  CHECK(PlacementFor(500).center_in_world != PlacementFor(501).center_in_world);
  CHECK_THROWS_AS(ReadRealGround("no_such_place"), std::runtime_error);
}

}  // namespace
}  // namespace freelsd
