#include "engine/regions/region_update.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>

#include <doctest/doctest.h>

#include "tests/engine/refusal.h"
#include "tests/engine/regions/detections.h"

namespace freelsd {
namespace {

constexpr int kPaperMinNumObservations = 10;

// A centre inside the corners is enough, whatever the surface.
RegionsOptions PaperRule() {
  RegionsOptions options;
  options.min_overlap_of_unlike_ratio = 0.0;
  return options;
}

TEST_CASE("regions: the paper's grading trace comes out, from 9 to 77 observations") {
  RegionTracker tracker(RegionsOptions{});
  // The good region has 8 grass of 10, the bad one 5 of 10 and never again.
  for (size_t view = 0; view < 77; ++view) {
    const bool is_good = view != 3 && view != 6;
    const bool is_bad = view < 10 && view % 2 == 0;
    tracker.Update(Stamp(view),
                   {Rectangle(0, 0, 60, 60, is_good), Rectangle(200, 0, 60, 60, is_bad)},
                   kPaperMinNumObservations);
  }
  // What the paper plots: n_obs - 20 until there is a grade.
  const auto plotted = [](const RegionHistory& state) {
    return state.num_observations < kPaperMinNumObservations
               ? state.num_observations - 20
               : static_cast<int>(std::floor(100.0 * state.grade));
  };
  std::vector<Region> ranked = tracker.Ranked();
  REQUIRE(ranked.size() == 2);
  const std::vector<RegionHistory>& good = ranked[0].history;
  const std::vector<RegionHistory>& bad = ranked[1].history;
  REQUIRE(good.size() == 77);
  CHECK(plotted(good[8]) == -11);
  CHECK(good[8].grade == 0.0);
  CHECK(plotted(good[9]) == 80);
  CHECK(good[9].num_grass_observations == 8);
  CHECK(plotted(bad[9]) == 50);
  CHECK(plotted(bad[76]) == 6);
  CHECK(bad[76].num_observations == 77);
  CHECK(good[76].frame_id == "frame 76");
  CHECK(good[76].area_m2 == doctest::Approx(3600.0));
  CHECK(ranked[0].first_seen_frame_id == "frame 0");
  CHECK(ranked[0].last_seen_us == 76000);
}

TEST_CASE("regions: a region that is too small never has a grade") {
  RegionTracker tracker(RegionsOptions{});
  for (size_t view = 0; view < 12; ++view) {
    tracker.Update(Stamp(view), {Rectangle(0, 0, 29, 30), Rectangle(100, 0, 30, 30)}, 10);
  }
  const std::vector<Region> ranked = tracker.Ranked();
  CHECK(ranked[0].grade == 1.0);
  CHECK(ranked[0].area_m2 == doctest::Approx(900.0));
  CHECK(ranked[1].grade == 0.0);
}

TEST_CASE("regions: corners seen whole are fixed, a re-detection changes statistics only") {
  RegionTracker tracker(PaperRule());
  tracker.Update(Stamp(0), {Rectangle(0, 0, 60, 40)}, 2);
  const auto corners = tracker.Ranked()[0].corners_in_world;
  tracker.Update(Stamp(1), {Rectangle(10, 5, 90, 90, false)}, 2);
  const std::vector<Region> ranked = tracker.Ranked();
  REQUIRE(ranked.size() == 1);
  CHECK(ranked[0].is_fixed);
  CHECK(ranked[0].corners_in_world == corners);
  CHECK(ranked[0].num_observations == 2);
  CHECK(ranked[0].num_grass_observations == 1);
  CHECK(ranked[0].grade == 0.5);
}

TEST_CASE("regions: a partly visible region grows round all eight corners until seen whole") {
  RegionTracker tracker(RegionsOptions{});
  tracker.Update(Stamp(0), {PartlyVisible(Rectangle(0, 0, 40, 40))}, 2);
  CHECK_FALSE(tracker.Ranked()[0].is_fixed);
  tracker.Update(Stamp(1), {PartlyVisible(Rectangle(15, 0, 40, 40))}, 2);
  Region region = tracker.Ranked()[0];
  CHECK_FALSE(region.is_fixed);
  CHECK(region.area_m2 == doctest::Approx(55.0 * 40.0));
  CHECK(SignedArea(region.Footprint()) > 0.0);
  tracker.Update(Stamp(2), {Rectangle(10, 0, 70, 42)}, 2);
  region = tracker.Ranked()[0];
  CHECK(region.is_fixed);
  CHECK(region.area_m2 == doctest::Approx(70.0 * 42.0));
  tracker.Update(Stamp(3), {PartlyVisible(Rectangle(20, 0, 90, 90))}, 2);
  CHECK(tracker.Ranked()[0].area_m2 == doctest::Approx(70.0 * 42.0));
}

TEST_CASE("regions: two halves and then the whole become one, with larger corners and older id") {
  RegionTracker tracker(RegionsOptions{});
  tracker.Update(Stamp(0), {Rectangle(-30, 0, 50, 50)}, 2);
  tracker.Update(Stamp(1), {Rectangle(30, 0, 50, 50, false)}, 2);
  REQUIRE(tracker.Ranked().size() == 2);
  const int oldest = 1;
  tracker.Update(Stamp(2), {Rectangle(0, 0, 110, 50)}, 2);
  const std::vector<Region> ranked = tracker.Ranked();
  REQUIRE(ranked.size() == 1);
  CHECK(ranked[0].id == oldest);
  CHECK(ranked[0].area_m2 == doctest::Approx(5500.0));
  CHECK(ranked[0].num_observations == 3);
  CHECK(ranked[0].num_grass_observations == 2);
  CHECK(ranked[0].last_seen_frame_id == "frame 2");
  CHECK(ranked[0].first_seen_frame_id == "frame 0");
}

TEST_CASE("regions: a view that saw both halves counts once after they are merged") {
  RegionTracker tracker(RegionsOptions{});
  tracker.Update(Stamp(0), {Rectangle(-30, 0, 50, 50, false), Rectangle(30, 0, 55, 50, true)}, 2);
  REQUIRE(tracker.Ranked().size() == 2);
  tracker.Update(Stamp(1), {Rectangle(0, 0, 110, 50)}, 2);
  REQUIRE(tracker.Ranked().size() == 1);
  CHECK(tracker.Ranked()[0].num_observations == 2);
  // In the first view the larger part was grass.
  CHECK(tracker.Ranked()[0].num_grass_observations == 2);
}

TEST_CASE("regions: several segments of one view on one region are one observation, by area") {
  RegionTracker tracker(PaperRule());
  tracker.Update(Stamp(0), {Rectangle(0, 0, 100, 100)}, 2);
  tracker.Update(Stamp(1),
                 {Rectangle(-30, 0, 20, 20, true),
                  Rectangle(30, 0, 40, 40, false),
                  Rectangle(0, 40, 15, 15, true)},
                 2);
  Region region = tracker.Ranked()[0];
  CHECK(region.num_observations == 2);
  CHECK(region.num_grass_observations == 1);
  tracker.Update(Stamp(2), {Rectangle(-30, 0, 50, 50, true), Rectangle(30, 0, 40, 40, false)}, 2);
  region = tracker.Ranked()[0];
  CHECK(region.num_observations == 3);
  CHECK(region.num_grass_observations == 2);
  CHECK(region.history.size() == 3);
}

// A flight over fields, with poses that are off by metres and segments that fall apart.
std::vector<std::vector<Detection>> NoisyFlight(unsigned seed, int num_views) {
  std::mt19937 random(seed);
  std::normal_distribution<double> pose_error(0.0, 5.0);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::vector<std::vector<Detection>> views;
  for (int view = 0; view < num_views; ++view) {
    std::vector<Detection> detections;
    const double east = pose_error(random), north = pose_error(random);
    for (int field = 0; field < 4; ++field) {
      const double center = 200.0 * field;
      const double kind = unit(random);
      if (kind < 0.5) {
        detections.push_back(Rectangle(center + east, north, 100, 60, field != 2));
      } else if (kind < 0.8) {
        detections.push_back(PartlyVisible(Rectangle(center + 15 + east, north, 70, 50)));
      } else {
        detections.push_back(Rectangle(center - 26 + east, north, 46, 58));
        detections.push_back(Rectangle(center + 26 + east, north, 46, 58));
      }
    }
    views.push_back(std::move(detections));
  }
  return views;
}

std::string Summary(const std::vector<Region>& regions) {
  std::string text;
  for (const Region& region : regions) {
    text += std::to_string(region.id) + " " + std::to_string(region.num_observations) + " " +
            std::to_string(region.num_grass_observations) + " " + std::to_string(region.area_m2) +
            " " + std::to_string(region.Center().x()) + "\n";
  }
  return text;
}

// Of the 80 fields of 20 flights.
int NumDuplicates(const RegionsOptions& options) {
  int num_duplicates = 0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    RegionTracker tracker(options);
    const auto views = NoisyFlight(seed, 40);
    for (size_t view = 0; view < views.size(); ++view) tracker.Update(Stamp(view), views[view], 10);
    const std::vector<Region> ranked = tracker.Ranked();
    REQUIRE(ranked.size() >= 4);
    const auto num_graded = std::count_if(
        ranked.begin(), ranked.end(), [](const Region& region) { return region.grade > 0.0; });
    CHECK(num_graded >= 4);
    num_duplicates += static_cast<int>(ranked.size()) - 4;
  }
  return num_duplicates;
}

TEST_CASE("regions: with poses off by metres a field stays one region") {
  CHECK(NumDuplicates(PaperRule()) <= 4);
}

TEST_CASE("regions: with the default rule a field is at most 1.1 regions on average") {
  CHECK(NumDuplicates(RegionsOptions{}) <= 8);
}

TEST_CASE("regions: the order of the segments within a view does not matter") {
  for (unsigned seed = 0; seed < 20; ++seed) {
    RegionTracker tracker(RegionsOptions{}), shuffled(RegionsOptions{});
    std::mt19937 random(seed + 100);
    const auto views = NoisyFlight(seed, 30);
    for (size_t view = 0; view < views.size(); ++view) {
      std::vector<Detection> detections = views[view];
      tracker.Update(Stamp(view), detections, 3);
      std::shuffle(detections.begin(), detections.end(), random);
      shuffled.Update(Stamp(view), detections, 3);
    }
    CHECK(Summary(tracker.Ranked()) == Summary(shuffled.Ranked()));
  }
}

TEST_CASE("regions: which of several regions came first does not change what is merged") {
  const std::vector<Detection> small{
      Rectangle(-40, 0, 30, 40), Rectangle(0, 0, 30, 40, false), Rectangle(40, 0, 32, 40)};
  std::vector<size_t> order{0, 1, 2};
  std::vector<double> areas;
  do {
    RegionTracker tracker(RegionsOptions{});
    for (size_t view = 0; view < 3; ++view) tracker.Update(Stamp(view), {small[order[view]]}, 2);
    tracker.Update(Stamp(3), {Rectangle(-18, 0, 90, 40)}, 2);
    tracker.Update(Stamp(4), {PartlyVisible(Rectangle(60, 30, 60, 90))}, 2);
    double area = 0.0;
    int num_observations = 0;
    for (const Region& region : tracker.Ranked()) {
      area += region.area_m2;
      num_observations += region.num_observations;
    }
    areas.push_back(area);
    CHECK(num_observations == 5);
  } while (std::next_permutation(order.begin(), order.end()));
  for (const double area : areas) CHECK(area == doctest::Approx(areas.front()));
}

TEST_CASE("regions: only the best are kept, and new ones still get their chance") {
  RegionsOptions options;
  options.max_num_regions = 3;
  RegionTracker tracker(options);
  const auto field = [](int i, bool is_grass) { return Rectangle(100.0 * i, 0, 50, 50, is_grass); };
  // Five regions: 0 and 1 are never grass, 2 to 4 are.
  for (size_t view = 0; view < 2; ++view) {
    tracker.Update(Stamp(view), {field(2, true), field(3, true), field(4, true)}, 2);
  }
  for (size_t view = 2; view < 4; ++view) {
    tracker.Update(Stamp(view), {field(0, false), field(1, false)}, 2);
  }
  std::vector<Region> ranked = tracker.Ranked();
  REQUIRE(ranked.size() == 3);
  for (const Region& region : ranked) CHECK(region.grade == 1.0);
  // A new field of equal grade pushes out one that was not seen recently.
  tracker.Update(Stamp(4), {field(3, true), field(4, true), field(7, true)}, 2);
  tracker.Update(Stamp(5), {field(7, true)}, 2);
  ranked = tracker.Ranked();
  REQUIRE(ranked.size() == 3);
  const auto is_kept = [&](int i) {
    return std::any_of(ranked.begin(), ranked.end(), [&](const Region& region) {
      return std::abs(region.Center().x() - 100.0 * i) < 1.0;
    });
  };
  CHECK(is_kept(7));
  CHECK(is_kept(4));
  CHECK(is_kept(3));
  CHECK_FALSE(is_kept(2));
}

TEST_CASE("regions: an empty view changes nothing") {
  RegionTracker tracker(RegionsOptions{});
  tracker.Update(Stamp(0), {}, 2);
  CHECK(tracker.Ranked().empty());
  tracker.Update(Stamp(1), {Rectangle(0, 0, 50, 50)}, 2);
  tracker.Update(Stamp(2), {}, 2);
  CHECK(tracker.Ranked()[0].num_observations == 1);
  CHECK(tracker.Ranked()[0].history.size() == 1);
}

// Views of 100 m x 100 m, `spacing` apart, on one line.
ViewOverlap LineOfViews(int num_views, double spacing) {
  ViewOverlap overlap;
  for (int view = 0; view < num_views; ++view) {
    const Eigen::Vector2d center(spacing * view, 0.0);
    const auto corner = [&](double x, double y) {
      return Eigen::Vector2d(center + Eigen::Vector2d(x, y));
    };
    const Polygon footprint{corner(-50, -50), corner(50, -50), corner(50, 50), corner(-50, 50)};
    overlap.Add(static_cast<size_t>(view), center, footprint);
    overlap.Add(static_cast<size_t>(view), center, footprint);  // counts once
  }
  return overlap;
}

TEST_CASE("regions: the observations needed follow from how often a place is seen") {
  const RegionsOptions options;
  CHECK(ViewOverlap().MinNumObservations(options) == 2);
  // 70 % overlap along the track: a centre is seen by itself and one neighbour on each side.
  const ViewOverlap survey = LineOfViews(40, 30.0);
  CHECK(survey.ExpectedNumViews() == 3);
  CHECK(survey.MinNumObservations(options) == 2);
  // 4 Hz: 2.5 m from frame to frame.
  CHECK(LineOfViews(120, 2.5).MinNumObservations(options) == 10);
  // In between: 10 m apart, 9 to 11 views.
  const int in_between = LineOfViews(80, 10.0).MinNumObservations(options);
  CHECK(in_between >= 4);
  CHECK(in_between <= 6);
}

TEST_CASE("regions: options out of bounds are refused by name") {
  using O = RegionsOptions;
  CHECK_NOTHROW(O().Check());
  CHECK_THROWS_AS(Regions(O{.min_area_m2 = 0.0}), std::invalid_argument);
  CHECK(RefusalOf(&O::min_area_m2, 0.0) == "regions.min_area_m2 = 0: must be positive and finite");
  CHECK(RefusalOf(&O::min_num_observations, 1) ==
        "regions.min_num_observations = 1: must be at least min_num_observations_floor = 2");
  CHECK(RefusalOf(&O::min_num_observations_floor, 1) ==
        "regions.min_num_observations_floor = 1: must be at least 2");
  CHECK(RefusalOf(&O::min_fixing_overlap_ratio, 1.5) ==
        "regions.min_fixing_overlap_ratio = 1.5: must be in [0, 1]");
  CHECK(IsRefused(&O::min_fixing_overlap_ratio, std::nan(""), "min_fixing_overlap_ratio"));
  CHECK(RefusalOf(&O::max_num_regions, 0) == "regions.max_num_regions = 0: must be at least 1");
  CHECK(RefusalOf(&O::border_margin_px, -1) ==
        "regions.border_margin_px = -1: must be at least 0 and finite");
  CHECK(RefusalOf(&O::max_viewing_distance_ratio, 1.0) ==
        "regions.max_viewing_distance_ratio = 1: must be greater than 1 and finite");
}

}  // namespace
}  // namespace freelsd
