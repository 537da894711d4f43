#include "api/export/layers/layers.h"
#include "tests/api/export/layers/hill_map.h"
#include "tests/api/export/sites/agreement.h"

namespace freelsd {
namespace {

// Corners as GDAL sees them, in the order of upper left, lower left, upper right, lower right.
std::vector<Eigen::Vector2d> CornersByGdal(const std::string& path) {
  const auto output = OutputOf("gdalinfo -json " + path);
  REQUIRE(output.has_value());
  const nlohmann::json corners = nlohmann::json::parse(*output)["cornerCoordinates"];
  std::vector<Eigen::Vector2d> places;
  for (const char* const name : {"upperLeft", "lowerLeft", "upperRight", "lowerRight"}) {
    places.emplace_back(corners[name][0], corners[name][1]);
  }
  return places;
}

TEST_CASE("world file: GDAL puts picture and GeoTIFF at the same place") {
  if (!IsInstalled("gdalinfo")) {
    MESSAGE("skipped: gdalinfo (gdal-bin) is not installed");
    return;
  }
  for (const GeoPoint& origin : {GeoPoint{47.4, 8.55, 450.0}, GeoPoint{-33.9, -70.7, 500.0}}) {
    const LocalFrame frame(origin);
    const SiteMap site_map = HillMap();
    const TemporaryFile png("layer.png", LayerPng(site_map, "slope"));
    const TemporaryFile world("layer.pgw", LayerWorldFile(site_map, frame));
    const TemporaryFile tif("layer.tif", LayerGeoTiff(site_map, "slope", frame));
    const auto from_png = CornersByGdal(png.path()), from_tif = CornersByGdal(tif.path());
    for (size_t i = 0; i < from_png.size(); ++i) {
      CHECK((from_png[i] - from_tif[i]).norm() < kMaxPlaceErrorM);
    }
  }
}

}  // namespace
}  // namespace freelsd
