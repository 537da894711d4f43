#include <cmath>

#include <doctest/doctest.h>
#include <opencv2/imgcodecs.hpp>

#include "api/export/color_ramp.h"
#include "engine/risk/risk.h"
#include "tests/api/export/map/scenes.h"

namespace freelsd {
namespace {

constexpr double kCellSizeM = 1.0;

// Level meadow, wholly certain, but for one cell.
MapWindow Meadow() {
  MapWindow window = RandomWindow({{0.0, 16.0}, kCellSizeM, 16, 16}, {1, 0.0, 0.0});
  auto& [map, layers] = window.site_map;
  map.elevation.setTo(3.0f);
  map.upper.setTo(3.0f);
  layers.slope.setTo(0.0f);
  layers.roughness.setTo(0.0f);
  layers.grass.setTo(1.0f);
  return window;
}

TEST_CASE(
    "risk layer: it tells the risk of the cell, by kind and by shape, and unseen stays unknown") {
  MapWindow window = Meadow();
  auto& [map, layers] = window.site_map;
  const Aircraft aircraft;
  layers.grass(2, 3) = 0.9f;
  layers.slope(4, 5) = static_cast<float>(0.9 * RadFromDeg(aircraft.max_slope_deg));
  layers.hazard(6, 7) = kUnseen;
  AddRisk(window, aircraft, kCellSizeM);
  const double least = RiskOfShape(0.0);
  CHECK(window.risk(0, 0) == doctest::Approx(least).epsilon(1e-4));
  CHECK(window.risk(2, 3) == doctest::Approx(1.0 - 0.9 * (1.0 - least)).epsilon(1e-4));
  CHECK(window.risk(4, 5) == doctest::Approx(RiskOfShape(0.9)).epsilon(1e-4));
  CHECK(std::isnan(window.risk(6, 7)));
}

TEST_CASE("risk layer: a coarse cell has the largest risk of its cells, and a slope is no object") {
  MapWindow window = Meadow();
  auto& [map, layers] = window.site_map;
  const Aircraft aircraft;
  const double slope = RadFromDeg(0.5 * aircraft.max_slope_deg);
  for (int row = 0; row < 16; ++row) {
    for (int col = 0; col < 16; ++col) {
      const auto height = static_cast<float>(std::tan(slope) * (row + col) / std::sqrt(2.0));
      map.elevation(row, col) = map.upper(row, col) = height;
      layers.slope(row, col) = static_cast<float>(slope);
    }
  }
  layers.grass(5, 6) = 0.8f;
  MapWindow coarse = Coarser(Coarser(window));
  AddRisk(coarse, aircraft, kCellSizeM);
  const double shape = RiskOfShape(0.5);
  CHECK(coarse.risk(0, 0) == doctest::Approx(shape).epsilon(1e-3));
  CHECK(coarse.risk(1, 1) == doctest::Approx(1.0 - 0.8 * (1.0 - shape)).epsilon(1e-3));
}

TEST_CASE("risk layer: a pixel shows the largest risk of the cells that it touches") {
  MapWindow window = Meadow();
  window.site_map.layers.grass(5, 6) = 0.9f;
  window.site_map.layers.hazard(13, 13) = kHazard;
  window.site_map.layers.hazard(1, 13) = kUnseen;
  AddRisk(window, Aircraft(), kCellSizeM);
  const std::string png = LayerBoxPng("risk",
                                      {{0.0, 0.0}, {16.0, 16.0}},
                                      4.0 * kCellSizeM,
                                      {window},
                                      RiskScale(),
                                      FrameAt(47.4, 8.55));
  const cv::Mat picture =
      cv::imdecode(std::vector<uint8_t>(png.begin(), png.end()), cv::IMREAD_COLOR);
  REQUIRE(picture.size() == cv::Size(4, 4));
  const auto is = [&](int row, int col, const Color& color) {
    const auto& pixel = picture.at<cv::Vec3b>(row, col);
    return std::abs(pixel[0] - color[2]) <= 2 && std::abs(pixel[1] - color[1]) <= 2 &&
           std::abs(pixel[2] - color[0]) <= 2;
  };
  const auto shown = [&](double risk) { return RampColor("risk", risk / RiskScale().max); };
  CHECK(is(1, 1, shown(1.0 - 0.9 * (1.0 - RiskOfShape(0.0)))));
  CHECK(is(2, 1, shown(RiskOfShape(0.0))));
  CHECK(is(3, 3, kHazardColor));
  CHECK(is(0, 3, kUnseenColor));
  CHECK_FALSE(shown(0.1) == shown(0.0));
}

}  // namespace
}  // namespace freelsd
