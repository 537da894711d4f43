#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "tests/api/export/map/scenes.h"

namespace freelsd {
namespace {

TEST_CASE("map: the list of layers is TileJSON with our members") {
  const LocalFrame frame = FrameAt(47.4, 8.55);
  MapDescription map;
  map.base_url = "https://host/v1/flights/7/map";
  map.extent = {{-500.0, -400.0}, {500.0, 400.0}};
  map.photo_pixel_size_m = 0.1;
  map.scales = {{"hazard", {0.0, 2.0}}, {"elevation", {430.5, 470.0}}};
  map.attribution = "a survey";
  map.updated_at = "2026-01-02T03:04:05Z";
  const nlohmann::json json = MapJson(map, frame);
  CHECK(json["updated_at"] == map.updated_at);
  REQUIRE(json["layers"].size() == 3);
  const nlohmann::json& photo = json["layers"][0];
  CHECK(photo["name"] == "photo");
  CHECK(photo["min"].is_null());
  CHECK(photo["legend"].is_null());
  CHECK(photo["kmz"] == "https://host/v1/flights/7/map/photo.kmz");
  const nlohmann::json& elevation = json["layers"][2];
  CHECK(elevation["tilejson"] == "3.0.0");
  CHECK(elevation["tiles"][0] == "https://host/v1/flights/7/map/elevation/{z}/{x}/{y}.png");
  CHECK(elevation["geotiff"] == "https://host/v1/flights/7/map/elevation.tif");
  CHECK(elevation["legend"] == "https://host/v1/flights/7/map/elevation/legend.png");
  CHECK(elevation["unit"] == "m");
  CHECK(elevation["min"] == 430.5);
  CHECK(elevation["max"] == 470.0);
  CHECK(elevation["attribution"] == "a survey");
  CHECK_FALSE(elevation.contains("kmz"));
  const auto bounds = elevation["bounds"].get<std::vector<double>>();
  REQUIRE(bounds.size() == 4);
  CHECK(bounds[0] < 8.55);
  CHECK(bounds[2] - bounds[0] == doctest::Approx(1000.0 / 75400.0).epsilon(0.01));
  CHECK(bounds[3] - bounds[1] == doctest::Approx(800.0 / 111180.0).epsilon(0.01));
  CHECK(elevation["center"][1] == doctest::Approx(47.4));
  // 0.1 m is 2^-20.0 of the equator's 1.06e5 m a tile pixel here; half a metre, 2^-17.7.
  CHECK(photo["maxzoom"] == 21);
  CHECK(elevation["maxzoom"] == 18);
  CHECK(elevation["minzoom"] == 11);
}

TEST_CASE("map: bounds across the antimeridian go around the earth, bad descriptions are refused") {
  MapDescription map;
  map.base_url = "http://h/map";
  map.extent = {{-500.0, -400.0}, {500.0, 400.0}};
  map.scales = {{"hazard", {0.0, 2.0}}};
  const nlohmann::json json = MapJson(map, FrameAt(10.0, 179.9999));
  CHECK(json["layers"][0]["bounds"][0] == -180.0);
  CHECK(json["layers"][0]["bounds"][2] == 180.0);
  const LocalFrame frame = FrameAt(10.0, 20.0);
  map.scales = {{"photo", {0.0, 2.0}}};
  CHECK_THROWS_AS(MapJson(map, frame), std::invalid_argument);
  map.scales = {{"hazard", {0.0, 0.0}}};
  CHECK_THROWS_AS(MapJson(map, frame), std::invalid_argument);
  map.scales = {};
  map.cell_size_m = 0.0;
  CHECK_THROWS_AS(MapJson(map, frame), std::invalid_argument);
}

}  // namespace
}  // namespace freelsd
