#include "api/export/layers/layers.h"

#include <cmath>
#include <stdexcept>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "tests/api/export/layers/hill_map.h"

namespace freelsd {
namespace {

const GeoPoint kOrigin{47.4, 8.55, 450.0};

TEST_CASE("layers: the JSON has the contract's names, order, units and corners") {
  const LocalFrame frame(kOrigin);
  const SiteMap site_map = HillMap();
  const nlohmann::json layers = LayersJson(site_map, frame)["layers"];
  REQUIRE(layers.size() == 6);
  std::vector<std::string> names;
  for (const auto& layer : layers) {
    names.push_back(layer["name"]);
    CHECK(layer["width_px"] == kHillCols);
    CHECK(layer["height_px"] == kHillRows);
    CHECK(layer["cell_size_m"] == 1.0);
    const auto& corners = layer["corners"];
    REQUIRE(corners.size() == 4);
    const auto north_west = frame.WorldFromGeo({corners[0][1], corners[0][0], kOrigin.altitude_m});
    CHECK((north_west.head<2>() - Eigen::Vector2d(-30.0, 40.0)).norm() < 1e-3);
    const auto south_east = frame.WorldFromGeo({corners[2][1], corners[2][0], kOrigin.altitude_m});
    CHECK((south_east.head<2>() - Eigen::Vector2d(50.0, -20.0)).norm() < 1e-3);
    CHECK(corners[1][0] > corners[0][0]);
    CHECK(corners[3][1] < corners[0][1]);
    const auto& bounds = layer["bounds"];
    CHECK(bounds[0] <= corners[0][0]);
    CHECK(bounds[1] <= corners[2][1]);
    CHECK(bounds[2] >= corners[1][0]);
    CHECK(bounds[3] >= corners[1][1]);
  }
  CHECK(names == LayerNames());
  CHECK(names ==
        std::vector<std::string>{"elevation", "slope", "roughness", "grass", "hazard", "distance"});
  CHECK(layers[0]["min"].get<double>() == doctest::Approx(452.0).epsilon(1e-5));
  CHECK(layers[0]["max"].get<double>() == doctest::Approx(464.0).epsilon(1e-5));
  CHECK(layers[1]["unit"] == "deg");
  CHECK(layers[1]["max"] > 20.0);
  CHECK(layers[1]["max"] < 60.0);
}

TEST_CASE("layers: a site without a map has no layers, and an unseen layer no range") {
  CHECK(LayersJson(SiteMap{}, LocalFrame(kOrigin)) ==
        nlohmann::json{{"layers", nlohmann::json::array()}});
  SiteMap unseen = HillMap();
  unseen.map.elevation.setTo(std::nanf(""));
  unseen.layers = AssessHazards(unseen.map, {}, {}, {});
  const nlohmann::json answer = LayersJson(unseen, LocalFrame(kOrigin));
  for (const auto& layer : answer["layers"]) {
    CHECK(layer["min"].is_null());
    CHECK(layer["max"].is_null());
  }
  CHECK_THROWS_AS(DescribeLayer(unseen, "height"), std::invalid_argument);
  CHECK_THROWS_AS(LayerPng(unseen, "../hazard"), std::invalid_argument);
  CHECK_THROWS_AS(LegendPng(unseen, ""), std::invalid_argument);
}

}  // namespace
}  // namespace freelsd
