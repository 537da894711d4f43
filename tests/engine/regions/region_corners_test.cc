// Which views fix the corners of a region.
#include <doctest/doctest.h>

#include "tests/engine/regions/detections.h"

namespace freelsd {
namespace {

TEST_CASE(
    "regions: a patch of a region seen whole leaves it growing, a view of all of it fixes it") {
  RegionTracker tracker(RegionsOptions{});
  tracker.Update(Stamp(0), {PartlyVisible(Rectangle(0, 0, 200, 180))}, 2);
  tracker.Update(Stamp(1), {Rectangle(20, 10, 20, 20)}, 2);
  Region region = tracker.Ranked()[0];
  CHECK_FALSE(region.is_fixed);
  CHECK(region.area_m2 == doctest::Approx(200.0 * 180.0));
  CHECK(region.num_observations == 2);
  // It grows on.
  tracker.Update(Stamp(2), {PartlyVisible(Rectangle(20, 0, 200, 180))}, 2);
  CHECK(tracker.Ranked()[0].area_m2 == doctest::Approx(220.0 * 180.0));
  tracker.Update(Stamp(3), {Rectangle(10, 0, 216, 176)}, 2);
  region = tracker.Ranked()[0];
  CHECK(region.is_fixed);
  CHECK(region.area_m2 == doctest::Approx(216.0 * 176.0));
}

TEST_CASE("regions: a patch beside a view of all of it does not keep it from being fixed") {
  RegionTracker tracker(RegionsOptions{});
  tracker.Update(Stamp(0), {PartlyVisible(Rectangle(0, 0, 100, 90))}, 2);
  tracker.Update(Stamp(1), {Rectangle(20, 10, 20, 20), Rectangle(0, 0, 110, 96)}, 2);
  CHECK(tracker.Ranked()[0].is_fixed);
  CHECK(tracker.Ranked()[0].area_m2 == doctest::Approx(110.0 * 96.0));
}

TEST_CASE("regions: the share of a region that fixes it is an option, 0 is the paper's") {
  const auto is_fixed_by = [](double width, double min_fixing_overlap_ratio) {
    RegionsOptions options;
    options.min_fixing_overlap_ratio = min_fixing_overlap_ratio;
    RegionTracker tracker(options);
    tracker.Update(Stamp(0), {PartlyVisible(Rectangle(0, 0, 100, 90))}, 2);
    tracker.Update(Stamp(1), {Rectangle(0, 0, width, 90)}, 2);
    return tracker.Ranked()[0].is_fixed;
  };
  CHECK(is_fixed_by(10.0, 0.0));
  CHECK_FALSE(is_fixed_by(45.0, 0.5));
  CHECK(is_fixed_by(55.0, 0.5));
  CHECK_FALSE(is_fixed_by(99.0, 1.0));
}

}  // namespace
}  // namespace freelsd
