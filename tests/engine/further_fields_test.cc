#include "engine/further_fields.h"

#include <doctest/doctest.h>

#include "tests/engine/approach/scene.h"

namespace freelsd {
namespace {

constexpr double kRequiredM = 10.0;
constexpr double kGroundM = 70.0;
constexpr int kAnyNumber = 8;

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

std::vector<Region> FieldsBeside(const Eigen::Vector2d& taken,
                                 const Evaluation& evaluation,
                                 int max_num_fields = kAnyNumber) {
  return FurtherFields(WholeRegion(), taken, evaluation, kRequiredM, max_num_fields);
}

TEST_CASE("further fields: beyond a hedge is a field of its own, the taken one is left out") {
  const Evaluation evaluation = MeadowWithHedges({-20.0});
  const std::vector<Region> fields = FieldsBeside({-60.0, 0.0}, evaluation);
  REQUIRE(fields.size() == 1);
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
  const std::vector<Region> others = FieldsBeside({60.0, 0.0}, evaluation);
  REQUIRE(others.size() == 1);
  CHECK(Contains(others.front().Footprint(), {-60.0, 0.0}));
}

TEST_CASE("further fields: the widest comes first, and the limit is kept") {
  const Evaluation evaluation = MeadowWithHedges({-70.0, -20.0, 10.0});
  const std::vector<Region> fields = FieldsBeside({-5.0, 0.0}, evaluation);
  REQUIRE(fields.size() == 3);
  CHECK(Contains(fields[0].Footprint(), {60.0, 0.0}));
  CHECK(Contains(fields[1].Footprint(), {-45.0, 0.0}));
  CHECK(Contains(fields[2].Footprint(), {-90.0, 0.0}));
  CHECK(FieldsBeside({-5.0, 0.0}, evaluation, 2).size() == 2);
  CHECK(FieldsBeside({-5.0, 0.0}, evaluation, 0).empty());
}

TEST_CASE("further fields: one piece of ground has none, nor has ground that is too narrow") {
  CHECK(FieldsBeside({0.0, 0.0}, MeadowWithHedges({})).empty());
  // 20 m between two hedges: less than two discs.
  CHECK(FieldsBeside({60.0, 0.0}, MeadowWithHedges({-98.0, -76.0, -54.0, -32.0, -10.0})).empty());
}

TEST_CASE(
    "further fields: an unseen strip parts fields as a hedge does, and unseen ground is none") {
  scene::Scene meadow = scene::FlatMeadow(160, 240);
  scene::AddUnseen(meadow, {-2.0, -80.0}, {2.0, 80.0});
  Evaluation evaluation;
  evaluation.map = meadow.map;
  evaluation.hazards = meadow.hazards;
  CHECK(FieldsBeside({-60.0, 0.0}, evaluation).size() == 1);
  scene::AddUnseen(meadow, {0.0, -80.0}, {120.0, 80.0});
  evaluation.map = meadow.map;
  evaluation.hazards = meadow.hazards;
  CHECK(FieldsBeside({-60.0, 0.0}, evaluation).empty());
}

TEST_CASE("further fields: an evaluation without a map, and an unknown distance, have none") {
  CHECK(FieldsBeside({0.0, 0.0}, Evaluation{}).empty());
  const double unknown = std::numeric_limits<double>::quiet_NaN();
  CHECK(FurtherFields(WholeRegion(), {60.0, 0.0}, MeadowWithHedges({-20.0}), unknown, kAnyNumber)
            .empty());
}

}  // namespace
}  // namespace freelsd
