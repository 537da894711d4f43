#include <algorithm>
#include <limits>
#include <stdexcept>
#include <utility>

#include <doctest/doctest.h>

#include "engine/selection/selection.h"
#include "tests/engine/approach/scene.h"

namespace freelsd {
namespace {

constexpr double kGroundM = 70.0;
constexpr int kNumViews = 5;

// The western part of the meadow, as the tracking saw it.
Region WesternRegion() {
  Region region;
  region.id = 4;
  region.num_observations = 7;
  region.num_grass_observations = 6;
  region.grade = 0.9;
  for (const Eigen::Vector2d& corner : scene::Box({-100, -60}, {-30, 60})) {
    region.corners_in_world.emplace_back(corner.x(), corner.y(), kGroundM);
  }
  region.area_m2 = 70.0 * 120.0;
  return region;
}

// A meadow that rises to the east, 240 m by 160 m, with hedges across it at these places.
scene::Scene MeadowWithHedges(const std::vector<double>& hedges_east) {
  scene::Scene meadow = scene::Meadow(
      160, 240, 1.0, [](const Eigen::Vector2d& place) { return kGroundM + 0.05 * place.x(); });
  for (const double east : hedges_east) {
    scene::AddBlock(meadow, {east - 2.0, -80.0}, {east + 2.0, 80.0}, 3.0);
  }
  return meadow;
}

Site SiteAt(const Region& region, Verdict verdict, double score) {
  Site site;
  site.region = region;
  site.plan.verdict = verdict;
  site.plan.touchdown_in_world = region.Center();
  site.plan.score = score;
  return site;
}

// How a piece is planned: it touches down in its middle.
using PlanPiece = std::function<Site(const Region&)>;
Site Landable(const Region& field) { return SiteAt(field, Verdict::kLandable, 0.9); }

std::vector<Site> SitesOn(const scene::Scene& ground,
                          std::vector<Site> of_regions,
                          const PlanPiece& plan,
                          const PipelineOptions& options = {}) {
  const cv::Mat1b num_views(ground.map.elevation.size(), uint8_t{kNumViews});
  const auto plan_all = [&plan](const std::vector<Region>& fields) {
    std::vector<Site> sites;
    sites.reserve(fields.size());
    for (const Region& field : fields) sites.push_back(plan(field));
    return sites;
  };
  return WithMapSites(std::move(of_regions),
                      {ground.map, ground.hazards, num_views},
                      Aircraft{},
                      options,
                      plan_all);
}

bool IsAnyAt(const std::vector<Site>& sites, double from_east, double to_east) {
  return std::any_of(sites.begin(), sites.end(), [&](const Site& site) {
    const double east = site.plan.touchdown_in_world.x();
    return east > from_east && east < to_east;
  });
}

double LeastDistance(const std::vector<Site>& sites) {
  double least = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < sites.size(); ++i) {
    for (size_t j = 0; j < i; ++j) {
      const Eigen::Vector3d apart =
          sites[i].plan.touchdown_in_world - sites[j].plan.touchdown_in_world;
      least = std::min(least, apart.head<2>().norm());
    }
  }
  return least;
}

TEST_CASE("map sites: ground that no region covers gets its sites too, a strip's length apart") {
  const std::vector<Site> sites = SitesOn(MeadowWithHedges({-20.0}), {}, Landable);
  REQUIRE(sites.size() >= 4);
  CHECK(IsAnyAt(sites, -120.0, -22.0));
  CHECK(IsAnyAt(sites, -18.0, 120.0));
  const Aircraft aircraft;
  CHECK(LeastDistance(sites) >= 2.0 * aircraft.touchdown_uncertainty_m + aircraft.ground_roll_m);
  for (const Site& site : sites) {
    CHECK(site.region.id == kNoRegion);
    CHECK(site.square);
    CHECK(site.region.num_observations == kNumViews);
    CHECK(site.region.grade > 0.5);
  }
}

TEST_CASE("map sites: the best come first, and the last ones are left out") {
  const auto better_in_the_east = [](const Region& field) {
    return SiteAt(field, Verdict::kLandable, 0.5 + 0.001 * field.Center().x());
  };
  const auto is_worse = [](const Site& a, const Site& b) { return a.plan.score > b.plan.score; };
  const scene::Scene meadow = MeadowWithHedges({});
  const std::vector<Site> all = SitesOn(meadow, {}, better_in_the_east);
  REQUIRE(all.size() > 2);
  CHECK(std::is_sorted(all.begin(), all.end(), is_worse));
  PipelineOptions options;
  options.backend.max_num_map_sites = 2;
  const std::vector<Site> best = SitesOn(meadow, {}, better_in_the_east, options);
  REQUIRE(best.size() == 2);
  CHECK(best[0].plan.touchdown_in_world == all[0].plan.touchdown_in_world);
  options.backend.max_num_map_sites = 0;
  CHECK(SitesOn(meadow, {}, better_in_the_east, options).empty());
}

TEST_CASE("map sites: a site in a tracked region has its id and its observations") {
  const Region region = WesternRegion();
  const Site own = SiteAt(region, Verdict::kRejected, 0.0);
  const std::vector<Site> sites = SitesOn(MeadowWithHedges({-20.0}), {own}, Landable);
  REQUIRE(sites.size() > 2);
  CHECK_FALSE(sites[0].square);
  int num_inside = 0;
  for (size_t i = 1; i < sites.size(); ++i) {
    const Eigen::Vector2d place = sites[i].plan.touchdown_in_world.head<2>();
    const bool is_inside = Contains(region.Footprint(), place);
    num_inside += is_inside;
    CHECK(sites[i].region.id == (is_inside ? region.id : kNoRegion));
    CHECK(sites[i].region.num_observations == (is_inside ? 7 : kNumViews));
  }
  CHECK(num_inside > 0);
}

TEST_CASE("map sites: none beside an accepted site of a region, none where the plan is refused") {
  const Site own = SiteAt(WesternRegion(), Verdict::kLandable, 0.9);
  const std::vector<Site> sites = SitesOn(MeadowWithHedges({}), {own}, Landable);
  const Aircraft aircraft;
  CHECK(LeastDistance(sites) >= 2.0 * aircraft.touchdown_uncertainty_m + aircraft.ground_roll_m);
  CHECK(SitesOn(MeadowWithHedges({}), {own}, [](const Region& field) {
          return SiteAt(field, Verdict::kRejected, 0.0);
        }).size() == 1);
}

TEST_CASE("map sites: narrow and unseen ground, and an unknown position of the map, have none") {
  // 18 m between hedges: less than two discs. The ends are narrow too.
  std::vector<double> hedges;
  for (double east = -119.0; east <= 119.0; east += 21.8) hedges.push_back(east);
  CHECK(SitesOn(MeadowWithHedges(hedges), {}, Landable).empty());
  scene::Scene meadow = MeadowWithHedges({});
  meadow.map.position_sd_m = std::numeric_limits<double>::quiet_NaN();
  CHECK(SitesOn(meadow, {}, Landable).empty());
  scene::AddUnseen(meadow, {-120.0, -80.0}, {120.0, 80.0});
  meadow.map.position_sd_m = 0.0;
  CHECK(SitesOn(meadow, {}, Landable).empty());
  CHECK(SitesOn(scene::Scene{}, {}, Landable).empty());
}

TEST_CASE("map sites: their number and extent are checked") {
  BackendOptions options;
  options.max_num_map_sites = 0;
  CHECK_NOTHROW(options.Check());
  options.max_num_map_sites = -1;
  CHECK_THROWS_AS(options.Check(), std::invalid_argument);
  options = {};
  options.map_site_extent_m = 0.0;
  CHECK_THROWS_AS(options.Check(), std::invalid_argument);
}

}  // namespace
}  // namespace freelsd
