#include <cmath>
#include <limits>

#include <doctest/doctest.h>

#include "api/stored/map/map.h"

namespace freelsd {
namespace {

MapHead SomeHead() {
  MapHead head;
  head.flight_json = R"({"name":"a meadow"})";
  head.origin = {50.1, 8.2, 312.25};
  head.grid = {{-31.0, 12.0}, 0.5, 40, 50};
  head.num_levels = 3;
  head.position_sd_m = 1.0 / 3.0;
  head.tilt_sd_deg = 0.1;
  head.is_compared = true;
  head.wind = WindEstimate{.wind_in_world = {1.5, -2.0}, .spread_mps = 0.7};
  head.camera.width_px = 640;
  head.camera.height_px = 480;
  head.camera.fx_px = head.camera.fy_px = 500.0 / 3.0;
  head.camera.cx_px = 320.0;
  head.camera.cy_px = 240.0;
  head.views.push_back({"a.jpg", {Eigen::Quaterniond(0.0, 1.0, 0.0, 0.0), {1.0, 2.0, 100.1}}, {}});
  head.views.push_back({"b.jpg",
                        {Eigen::Quaterniond(0.0, 1.0, 0.0, 0.0), {-1234.0 / 7.0, 2.0, 100.1}},
                        Readout::Turning({0.1, 0.2, 0.3}, {0.0, 0.0, 0.01})});
  head.views[0].partners = {1};
  head.views[0].height_above_ground = 80.0 / 3.0;
  head.program_version = "1.2.3";
  head.model_sha256 = "ab";
  head.ranges = {{"elevation", -1.0, 12.5}};
  head.photo = PhotoLattice{1.0 / 19.0, 256, 5};
  head.quality = {2.5, 0.25, 3, 2, 100, "one is not connected"};
  return head;
}

TEST_CASE("map head: what was stored comes back, every number exactly") {
  const MapHead head = SomeHead();
  const std::string text = MapHeadJson(head);
  const MapHead back = ParseMapHead(text);
  CHECK(MapHeadJson(back) == text);
  CHECK(back.grid == head.grid);
  CHECK(back.position_sd_m == head.position_sd_m);
  CHECK(back.is_compared);
  CHECK(back.photo->pixel_size_m == head.photo->pixel_size_m);
  CHECK(back.photo->num_levels == 5);
  REQUIRE(back.views.size() == 2);
  CHECK(back.views[1].frame_id == "b.jpg");
  CHECK(back.views[1].world_from_camera.translation == head.views[1].world_from_camera.translation);
  CHECK(back.views[1].readout.turns == head.views[1].readout.turns);
  CHECK(back.views[0].readout.IsGlobal());
  CHECK(back.views[0].partners == std::vector<size_t>{1});
  CHECK(back.views[0].height_above_ground == head.views[0].height_above_ground);
  CHECK(back.program_version == "1.2.3");
  CHECK(back.model_sha256 == "ab");
  CHECK(back.wind->wind_in_world == head.wind->wind_in_world);
  CHECK(back.quality.note == head.quality.note);
}

TEST_CASE("map head: an unknown deviation and an unknown wind stay unknown") {
  MapHead head = SomeHead();
  head.position_sd_m = std::numeric_limits<double>::quiet_NaN();
  head.wind.reset();
  const MapHead back = ParseMapHead(MapHeadJson(head));
  CHECK(std::isnan(back.position_sd_m));
  CHECK_FALSE(back.wind);
}

TEST_CASE("map head: another text is refused") {
  CHECK_THROWS_AS(ParseMapHead("{}"), std::exception);
  CHECK_THROWS_AS(ParseMapHead("no JSON"), std::exception);
  MapHead beyond = SomeHead();
  beyond.views[0].partners = {2};
  CHECK_THROWS_AS(ParseMapHead(MapHeadJson(beyond)), std::exception);
  std::string newer = MapHeadJson(SomeHead());
  newer.replace(newer.find("\"version\":1"), 11, "\"version\":2");
  CHECK_THROWS_WITH_AS(ParseMapHead(newer), doctest::Contains("version 2"), std::runtime_error);
}

}  // namespace
}  // namespace freelsd
