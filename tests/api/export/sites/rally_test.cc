#include "tests/api/export/sites/agreement.h"

namespace freelsd {
namespace {

TEST_CASE("rally: ArduPilot's land direction is the heading, altitudes are above home") {
  for (const KnownSite& site : ManySites()) {
    const double home_m = site.touchdown.altitude_m - 30.0;
    const auto lines = SplitRows(ExportSites("rally", {site.stored}, {home_m}), '\n');
    REQUIRE(lines.size() == 3);
    const auto cells = SplitRows(lines[2][0].substr(6), '\t')[0];
    REQUIRE(cells.size() == 6);
    CHECK(MetresBetween({Number(cells[0]), Number(cells[1]), 0.0}, site.touchdown) <
          kMaxPlaceErrorM);
    CHECK(Number(cells[2]) == doctest::Approx(130.0).epsilon(1e-4));
    CHECK(std::abs(Number(cells[3]) - (site.start.altitude_m - home_m)) < kMaxAltitudeErrorM);
    CHECK(DegreesBetween(Number(cells[4]), site.heading_deg) < kMaxHeadingErrorDeg);
  }
}

TEST_CASE("rally: the plan has the same points above home, and none without home") {
  const KnownSite site = MakeSite({});
  CHECK(nlohmann::json::parse(Export("plan", site))["rallyPoints"]["points"].empty());
  const nlohmann::json plan = nlohmann::json::parse(ExportSites("plan", {site.stored}, {400.0}));
  const nlohmann::json& point = plan["rallyPoints"]["points"].at(0);
  CHECK(MetresBetween({point[0], point[1], 0.0}, site.touchdown) < kMaxPlaceErrorM);
  CHECK(point[2].get<double>() == doctest::Approx(site.touchdown.altitude_m - 300.0));
}

}  // namespace
}  // namespace freelsd
