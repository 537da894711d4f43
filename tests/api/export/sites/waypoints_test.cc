#include "tests/api/export/sites/agreement.h"

namespace freelsd {
namespace {

TEST_CASE("waypoints: land start, circle on the right side, landing, in the right order") {
  for (const KnownSite& site : ManySites()) {
    const std::string text = Export("waypoints", site);
    const auto rows = SplitRows(text, '\t');
    REQUIRE(rows.size() == 5);
    REQUIRE(rows[0][0] == "QGC WPL 110");
    const std::vector<std::string> commands{"16", "189", "31", "21"};
    for (size_t i = 0; i < commands.size(); ++i) {
      REQUIRE(rows[i + 1].size() == 12);
      CHECK(rows[i + 1][0] == std::to_string(i));
      CHECK(rows[i + 1][2] == "0");  // above mean sea level, as the site
      CHECK(rows[i + 1][3] == commands[i]);
    }
    const auto place = [&rows](size_t row) -> GeoPoint {
      return {Number(rows[row][8]), Number(rows[row][9]), Number(rows[row][10])};
    };
    CheckPlace(place(4), site.touchdown);
    CHECK(MetresBetween(place(3), site.loiter_center) < kMaxPlaceErrorM);
    CHECK(std::abs(place(3).altitude_m - site.start.altitude_m) < kMaxAltitudeErrorM);
    const double radius_m = Number(rows[3][5]) * (site.is_right_turn ? 1.0 : -1.0);
    CHECK(std::abs(radius_m - site.loiter_radius_m) < kMaxPlaceErrorM);
  }
}

}  // namespace
}  // namespace freelsd
