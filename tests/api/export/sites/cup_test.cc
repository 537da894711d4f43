#include "tests/api/export/sites/agreement.h"

namespace freelsd {
namespace {

TEST_CASE("cup: a landable within its thousandths of minutes, with direction and style") {
  for (const KnownSite& site : ManySites()) {
    const auto rows = SplitRows(Export("cup", site), ',');
    REQUIRE(rows.size() == 2);
    const std::vector<std::string>& cells = rows[1];
    REQUIRE(cells.size() == 11);
    REQUIRE(cells[3].size() == 9);
    REQUIRE(cells[4].size() == 10);
    const double latitude = (Number(cells[3].substr(0, 2)) + Number(cells[3].substr(2, 6)) / 60) *
                            (cells[3][8] == 'S' ? -1 : 1);
    const double longitude = (Number(cells[4].substr(0, 3)) + Number(cells[4].substr(3, 6)) / 60) *
                             (cells[4][9] == 'W' ? -1 : 1);
    CHECK(MetresBetween({latitude, longitude, 0.0}, site.touchdown) < kMaxCupErrorM);
    CHECK(std::abs(Number(cells[5]) - site.touchdown.altitude_m) <= 0.051);
    CHECK(cells[6] == "3");
    CHECK(DegreesBetween(Number(cells[7]), site.heading_deg) <= 0.51);
    CHECK(Number(cells[7]) >= 1.0);
  }
}

TEST_CASE("cup: each site of a region has a code of its own") {
  KnownSite site = MakeSite({.region_id = 7});
  CHECK(SplitRows(Export("cup", site), ',')[1][1] == "R7");
  site.stored.id = "f1-r7-f2";
  CHECK(SplitRows(Export("cup", site), ',')[1][1] == "R7F2");
}

TEST_CASE("cup: minutes never reach 60") {
  KnownSiteOptions options;
  options.origin = {46.9999999, 7.9999999, 450.0};
  options.touchdown_in_world = {0.0, 0.0, 0.0};
  const auto rows = SplitRows(Export("cup", MakeSite(options)), ',');
  CHECK(rows[1][3] == "4700.000N");
  CHECK(rows[1][4] == "00800.000E");
}

}  // namespace
}  // namespace freelsd
