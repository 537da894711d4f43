#include "engine/further_fields.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <doctest/doctest.h>

#include "tests/engine/approach/scene.h"

namespace freelsd {
namespace {

constexpr double kRequiredM = 10.0;
constexpr double kGroundM = 70.0;
constexpr double kUncutM = 1000.0;

// One rectangle from -100 to 100 east and -60 to 60 north.
Region WholeRegion() {
  Region region;
  region.id = 4;
  region.num_observations = 7;
  region.num_grass_observations = 6;
  region.grade = 0.9;
  for (const Eigen::Vector2d& corner : scene::Box({-100, -60}, {100, 60})) {
    region.corners_in_world.emplace_back(corner.x(), corner.y(), 0.0);
  }
  region.area_m2 = 200.0 * 120.0;
  return region;
}

// A meadow that rises to the east, with hedges across it at these places.
Evaluation MeadowWithHedges(const std::vector<double>& hedges_east) {
  scene::Scene meadow = scene::Meadow(
      160, 240, 1.0, [](const Eigen::Vector2d& place) { return kGroundM + 0.05 * place.x(); });
  for (const double east : hedges_east) {
    scene::AddBlock(meadow, {east - 2.0, -80.0}, {east + 2.0, 80.0}, 3.0);
  }
  Evaluation evaluation;
  evaluation.map = meadow.map;
  evaluation.hazards = meadow.hazards;
  return evaluation;
}

std::vector<Region> FieldsOf(const Evaluation& evaluation, double max_extent_m = kUncutM) {
  return FurtherFields(WholeRegion(), evaluation, kRequiredM, max_extent_m);
}

TEST_CASE("further fields: on either side of a hedge is a field of its own") {
  const std::vector<Region> fields = FieldsOf(MeadowWithHedges({-20.0}));
  REQUIRE(fields.size() == 2);
  const Region& field = fields.front();
  const Polygon footprint = field.Footprint();
  CHECK(footprint.size() == 4);
  CHECK(SignedArea(footprint) > 0.0);
  CHECK(field.area_m2 == doctest::Approx(Area(footprint)));
  // From the hedge to the region's end, with the discs of the outermost touchdowns.
  CHECK(field.Center().x() == doctest::Approx(0.5 * (-18.0 + 100.0 + kRequiredM)).epsilon(0.05));
  CHECK(field.Center().z() == doctest::Approx(kGroundM + 0.05 * 46.0).epsilon(0.01));
  CHECK(Contains(footprint, {-7.0, 0.0}));
  CHECK(Contains(footprint, {99.0, 0.0}));
  CHECK_FALSE(Contains(footprint, {-20.0, 0.0}));
  // Everything else as observed.
  CHECK(field.id == 4);
  CHECK(field.num_observations == 7);
  CHECK(field.grade == 0.9);
  CHECK(Contains(fields.back().Footprint(), {-60.0, 0.0}));
}

TEST_CASE("further fields: the widest comes first") {
  const std::vector<Region> fields = FieldsOf(MeadowWithHedges({-70.0, -20.0, 10.0}));
  REQUIRE(fields.size() == 4);
  CHECK(Contains(fields[0].Footprint(), {60.0, 0.0}));
  CHECK(Contains(fields[1].Footprint(), {-45.0, 0.0}));
  CHECK(Contains(fields[2].Footprint(), {-90.0, 0.0}));
  CHECK(Contains(fields[3].Footprint(), {-5.0, 0.0}));
}

TEST_CASE(
    "further fields: what hangs together is cut into pieces of the extent, and loses nothing") {
  const Evaluation evaluation = MeadowWithHedges({});
  CHECK(FieldsOf(evaluation).size() == 1);
  constexpr double kExtentM = 60.0;
  const std::vector<Region> fields = FieldsOf(evaluation, kExtentM);
  CHECK(fields.size() > 4);
  for (const Region& field : fields) {
    // With the discs on either side.
    CHECK(field.area_m2 <= std::pow(kExtentM + 2.0 * kRequiredM, 2));
  }
  for (const double east : {-95.0, -30.0, 0.0, 31.0, 95.0}) {
    CHECK(std::any_of(fields.begin(), fields.end(), [&](const Region& field) {
      return Contains(field.Footprint(), {east, 20.0});
    }));
  }
}

TEST_CASE("further fields: ground that is too narrow is none") {
  // 20 m between two hedges: less than two discs.
  for (const Region& field : FieldsOf(MeadowWithHedges({-98.0, -76.0, -54.0, -32.0, -10.0}))) {
    CHECK_FALSE(Contains(field.Footprint(), {-43.0, 0.0}));
  }
}

TEST_CASE(
    "further fields: an unseen strip parts fields as a hedge does, and unseen ground is none") {
  scene::Scene meadow = scene::FlatMeadow(160, 240);
  scene::AddUnseen(meadow, {-2.0, -80.0}, {2.0, 80.0});
  Evaluation evaluation;
  evaluation.map = meadow.map;
  evaluation.hazards = meadow.hazards;
  CHECK(FieldsOf(evaluation).size() == 2);
  scene::AddUnseen(meadow, {0.0, -80.0}, {120.0, 80.0});
  evaluation.map = meadow.map;
  evaluation.hazards = meadow.hazards;
  CHECK(FieldsOf(evaluation).size() == 1);
}

TEST_CASE("further fields: an evaluation without a map, and an unknown distance, have none") {
  CHECK(FieldsOf(Evaluation{}).empty());
  const double unknown = std::numeric_limits<double>::quiet_NaN();
  CHECK(FurtherFields(WholeRegion(), MeadowWithHedges({-20.0}), unknown, kUncutM).empty());
}

}  // namespace
}  // namespace freelsd
