#include "tests/api/export/sites/agreement.h"

namespace freelsd {
namespace {

TEST_CASE("plan: QGroundControl finds our touchdown, heading, distance and glide slope") {
  double worst_heading_deg = 0.0, worst_distance_ratio = 0.0, worst_radius_ratio = 0.0;
  for (const KnownSite& site : ManySites()) {
    const LandingPattern pattern = ReadPlan(Export("plan", site));
    CheckPlace(pattern.land, site.touchdown);
    CHECK(MetresBetween(pattern.loiter_center, site.loiter_center) < kMaxPlaceErrorM);
    CHECK(pattern.is_clockwise == site.is_right_turn);
    const double heading_error_deg = DegreesBetween(pattern.heading_deg, site.heading_deg);
    CHECK(heading_error_deg < kMaxHeadingErrorDeg);
    const double height_m = site.start.altitude_m - site.touchdown.altitude_m;
    const double slope_deg = DegFromRad(std::atan2(height_m, site.distance_m));
    CHECK(std::abs(pattern.glide_slope_deg - slope_deg) < kMaxGlideSlopeErrorDeg);
    worst_heading_deg = std::max(worst_heading_deg, heading_error_deg);
    worst_distance_ratio =
        std::max(worst_distance_ratio, std::abs(pattern.distance_m / site.distance_m - 1.0));
    worst_radius_ratio = std::max(worst_radius_ratio,
                                  std::abs(pattern.loiter_radius_m / site.loiter_radius_m - 1.0));
  }
  CHECK(worst_distance_ratio < kMaxSphereErrorRatio * 2.0);
  CHECK(worst_radius_ratio < kMaxSphereErrorRatio * 2.0);
  MESSAGE("plan: heading within " << worst_heading_deg << " deg, distance within "
                                  << 100.0 * worst_distance_ratio << " %, radius within "
                                  << 100.0 * worst_radius_ratio << " %");
}

TEST_CASE("plan: in the middle latitudes of the paper's flights the distance is within 0.5 m") {
  constexpr double kMaxDistanceErrorM = 0.5;
  for (int i = 0; i < 36; ++i) {
    KnownSiteOptions options;
    options.heading = RadFromDeg(10.0 * i);
    options.direction = i % 2 == 0 ? LoiterDirection::kLeft : LoiterDirection::kRight;
    const KnownSite site = MakeSite(options);
    const LandingPattern pattern = ReadPlan(Export("plan", site));
    CHECK(std::abs(pattern.distance_m - site.distance_m) < kMaxDistanceErrorM);
    CHECK(DegreesBetween(pattern.heading_deg, site.heading_deg) < kMaxHeadingErrorDeg);
  }
}

}  // namespace
}  // namespace freelsd
