#include <cmath>

#include <doctest/doctest.h>
#include <opencv2/imgcodecs.hpp>

#include "api/export/layers/layers.h"
#include "tests/api/export/layers/hill_map.h"

namespace freelsd {
namespace {

cv::Mat4b DecodePng(const std::string& bytes) {
  const std::vector<uint8_t> buffer(bytes.begin(), bytes.end());
  return cv::imdecode(buffer, cv::IMREAD_UNCHANGED);
}

double Brightness(const cv::Vec4b& bgra) {
  return 0.114 * bgra[0] + 0.587 * bgra[1] + 0.299 * bgra[2];
}

TEST_CASE("layers: a hill in the north-east is bright in the picture's top right") {
  const cv::Mat4b picture = DecodePng(LayerPng(HillMap(), "elevation"));
  REQUIRE(picture.size() == cv::Size(kHillCols, kHillRows));
  CHECK(Brightness(picture(12, 65)) > Brightness(picture(12, 15)) + 60);
  CHECK(Brightness(picture(12, 65)) > Brightness(picture(48, 65)) + 60);
  CHECK(Brightness(picture(12, 65)) > Brightness(picture(48, 15)) + 60);
  // Lit from the north-west.
  CHECK(Brightness(picture(8, 61)) > Brightness(picture(16, 69)));
}

TEST_CASE("layers: unseen is transparent, but opaque and unlike safe ground where safety is read") {
  const SiteMap site_map = HillMap();
  for (const std::string& name : LayerNames()) {
    const cv::Mat4b picture = DecodePng(LayerPng(site_map, name));
    REQUIRE(picture.size() == cv::Size(kHillCols, kHillRows));
    const bool is_safety = name == "hazard" || name == "distance";
    const cv::Vec4b unseen = picture(58, 2), seen = picture(30, 20);
    CHECK(seen[3] == 255);
    CHECK(unseen[3] == (is_safety ? 255 : 0));
    if (!is_safety) continue;
    for (int row = 0; row < kHillRows; ++row) {
      for (int col = 0; col < kHillCols; ++col) {
        REQUIRE(picture(row, col)[3] == 255);
        const bool is_free = site_map.layers.hazard(row, col) == kFree;
        const bool looks_unseen = std::abs(Brightness(picture(row, col)) - Brightness(unseen)) < 30;
        if (is_free) REQUIRE_FALSE(looks_unseen);
        if (site_map.layers.hazard(row, col) == kUnseen) REQUIRE(picture(row, col) == unseen);
      }
    }
  }
}

TEST_CASE("layers: pictures and legends of every layer can be read, also of an empty map") {
  for (const std::string& name : LayerNames()) {
    CHECK(DecodePng(LayerPng(SiteMap{}, name)).size() == cv::Size(1, 1));
    const std::string legend = LegendPng(HillMap(), name, 450.0);
    CHECK(cv::imdecode(std::vector<uint8_t>(legend.begin(), legend.end()), cv::IMREAD_COLOR).cols >
          100);
    CHECK_FALSE(LegendPng(SiteMap{}, name).empty());
  }
}

}  // namespace
}  // namespace freelsd
