#include <algorithm>
#include <limits>
#include <stdexcept>

#include <doctest/doctest.h>

#include "engine/selection/selection.h"
#include "tests/engine/approach/scene.h"

namespace freelsd {
namespace {

constexpr double kRequiredM = 10.0;
constexpr double kGroundM = 70.0;
// Longer than the map: nothing is cut.
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
scene::Scene MeadowWithHedges(const std::vector<double>& hedges_east) {
  scene::Scene meadow = scene::Meadow(
      160, 240, 1.0, [](const Eigen::Vector2d& place) { return kGroundM + 0.05 * place.x(); });
  for (const double east : hedges_east) {
    scene::AddBlock(meadow, {east - 2.0, -80.0}, {east + 2.0, 80.0}, 3.0);
  }
  return meadow;
}

std::vector<Region> FieldsOf(const scene::Scene& ground, double max_extent_m = kUncutM) {
  return FurtherFields(WholeRegion(), ground.map, ground.hazards, kRequiredM, max_extent_m);
}

bool IsWithin(const Region& field, const Eigen::Vector2d& place) {
  return Contains(field.Footprint(), place);
}

TEST_CASE("further fields: either side of a hedge is a field of its own, the wider one first") {
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
  CHECK(IsWithin(field, {-7.0, 0.0}));
  CHECK(IsWithin(field, {99.0, 0.0}));
  CHECK_FALSE(IsWithin(field, {-20.0, 0.0}));
  // Everything else as observed.
  CHECK(field.id == 4);
  CHECK(field.num_observations == 7);
  CHECK(field.grade == 0.9);
  CHECK(IsWithin(fields.back(), {-60.0, 0.0}));
  CHECK_FALSE(IsWithin(fields.back(), {-15.0, 0.0}));
}

TEST_CASE("further fields: of many the widest come first") {
  const std::vector<Region> fields = FieldsOf(MeadowWithHedges({-70.0, -20.0, 10.0}));
  REQUIRE(fields.size() == 4);
  CHECK(IsWithin(fields[0], {60.0, 0.0}));
  CHECK(IsWithin(fields[1], {-45.0, 0.0}));
  CHECK(IsWithin(fields[2], {-87.0, 0.0}));
  CHECK(IsWithin(fields[3], {-5.0, 0.0}));
}

TEST_CASE("further fields: what hangs together is cut into pieces that cover all of it") {
  constexpr double kExtentM = 80.0;
  const scene::Scene meadow = MeadowWithHedges({});
  CHECK(FieldsOf(meadow).size() == 1);
  const std::vector<Region> fields = FieldsOf(meadow, kExtentM);
  CHECK(fields.size() >= 3);
  const double longest_m = kExtentM + 2.0 * kRequiredM;
  for (const Region& field : fields) {
    const Polygon footprint = field.Footprint();
    CHECK((footprint[1] - footprint[0]).norm() <= longest_m);
    CHECK((footprint[2] - footprint[1]).norm() <= longest_m);
  }
  for (double east = -99.5; east <= 99.5; east += 3.0) {
    for (double north = -59.5; north <= 59.5; north += 3.0) {
      CHECK(std::any_of(fields.begin(), fields.end(), [&](const Region& field) {
        return IsWithin(field, {east, north});
      }));
    }
  }
}

TEST_CASE("further fields: ground that is too narrow is none") {
  // 18 m between hedges: less than two discs. Without the ends, which are wide enough.
  std::vector<double> hedges;
  for (double east = -109.0; east <= 109.0; east += 21.8) hedges.push_back(east);
  CHECK(FieldsOf(MeadowWithHedges(hedges)).empty());
}

TEST_CASE("further fields: an unseen strip parts fields as a hedge does, unseen ground is none") {
  scene::Scene meadow = scene::FlatMeadow(160, 240);
  scene::AddUnseen(meadow, {-2.0, -80.0}, {2.0, 80.0});
  CHECK(FieldsOf(meadow).size() == 2);
  scene::AddUnseen(meadow, {-120.0, -80.0}, {120.0, 80.0});
  CHECK(FieldsOf(meadow).empty());
}

TEST_CASE("further fields: an evaluation without a map, and an unknown distance, have none") {
  CHECK(FieldsOf(scene::Scene{}).empty());
  const double unknown = std::numeric_limits<double>::quiet_NaN();
  const scene::Scene meadow = MeadowWithHedges({-20.0});
  CHECK(FurtherFields(WholeRegion(), meadow.map, meadow.hazards, unknown, kUncutM).empty());
}

// A site of the region that touches down here, or one that is refused.
Site SiteAt(const Region& region, const Eigen::Vector2d& place, Verdict verdict) {
  Site site;
  site.region = region;
  site.plan.verdict = verdict;
  site.plan.touchdown_in_world << place, kGroundM;
  return site;
}

// Sites of a meadow with two hedges, whose own one lies in the middle: its pieces are planned as
// given, and always touch down in their centre.
std::vector<Site> SitesWith(Verdict own, Verdict others, const PipelineOptions& options) {
  const scene::Scene meadow = MeadowWithHedges({-35.0, 35.0});
  return WithFurtherSites(
      {SiteAt(WholeRegion(), {0.0, 0.0}, own)},
      meadow.map,
      meadow.hazards,
      Aircraft{},
      options,
      [&](const Region& field) { return SiteAt(field, field.Center().head<2>(), others); });
}

TEST_CASE("further fields: each that one can land on gets a site, numbered, none beside another") {
  PipelineOptions options;
  const double half_m = 0.5 * options.backend.further_field_extent_m;
  const std::vector<Site> sites = SitesWith(Verdict::kLandable, Verdict::kUnverified, options);
  REQUIRE(sites.size() > 2);
  for (size_t i = 0; i < sites.size(); ++i) {
    CHECK(sites[i].field_number == static_cast<int>(i) + 1);
    CHECK(sites[i].region.id == 4);
    for (size_t j = 0; j < i; ++j) {
      CHECK((sites[i].plan.touchdown_in_world - sites[j].plan.touchdown_in_world).norm() >= half_m);
    }
  }
  options.backend.max_num_further_fields = 1;
  CHECK(SitesWith(Verdict::kLandable, Verdict::kUnverified, options).size() == 2);
  options.backend.max_num_further_fields = 0;
  CHECK(SitesWith(Verdict::kLandable, Verdict::kUnverified, options).size() == 1);
}

TEST_CASE("further fields: refused ones get none, nor do those of a region whose own is refused") {
  const PipelineOptions options;
  CHECK(SitesWith(Verdict::kLandable, Verdict::kRejected, options).size() == 1);
  CHECK(SitesWith(Verdict::kRejected, Verdict::kLandable, options).size() == 1);
}

TEST_CASE("further fields: their number and extent are checked") {
  BackendOptions options;
  options.max_num_further_fields = 0;
  CHECK_NOTHROW(options.Check());
  options.max_num_further_fields = -1;
  CHECK_THROWS_AS(options.Check(), std::invalid_argument);
  options = {};
  options.further_field_extent_m = 0.0;
  CHECK_THROWS_AS(options.Check(), std::invalid_argument);
}

}  // namespace
}  // namespace freelsd
