#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include <GeographicLib/UTMUPS.hpp>
#include <doctest/doctest.h>
#include <geotiff/geotiff.h>
#include <geotiff/geotiffio.h>
#include <geotiff/xtiffio.h>

#include "api/export/layers/layers.h"
#include "tests/api/export/layers/hill_map.h"

namespace freelsd {
namespace {

const GeoPoint kOrigin{47.4, 8.55, 450.0};

struct GeoTiff {
  cv::Mat1f values;
  Eigen::Matrix<double, 2, 3> utm_from_pixel;
  unsigned short epsg = 0;
  unsigned short raster_type = 0;
};

GeoTiff ReadBack(const std::string& bytes) {
  const auto path = std::filesystem::temp_directory_path() /
                    ("freelsd_layers_test_" + std::to_string(std::hash<std::string>{}(bytes)));
  std::ofstream(path, std::ios::binary) << bytes;
  TIFFSetWarningHandler(nullptr);  // of GDAL's tag for no data, which plain libtiff does not know
  TIFF* tiff = XTIFFOpen(path.c_str(), "r");
  REQUIRE(tiff != nullptr);
  uint32_t width = 0, height = 0;
  uint16_t format = 0, bits = 0;
  TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &width);
  TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &height);
  TIFFGetField(tiff, TIFFTAG_SAMPLEFORMAT, &format);
  TIFFGetField(tiff, TIFFTAG_BITSPERSAMPLE, &bits);
  REQUIRE(format == SAMPLEFORMAT_IEEEFP);
  REQUIRE(bits == 32);
  GeoTiff read;
  read.values = cv::Mat1f(static_cast<int>(height), static_cast<int>(width));
  for (uint32_t row = 0; row < height; ++row) {
    REQUIRE(TIFFReadScanline(tiff, read.values[static_cast<int>(row)], row, 0) == 1);
  }
  uint16_t count = 0;
  double* matrix = nullptr;
  REQUIRE(TIFFGetField(tiff, TIFFTAG_GEOTRANSMATRIX, &count, &matrix) == 1);
  REQUIRE(count == 16);
  read.utm_from_pixel << matrix[0], matrix[1], matrix[3], matrix[4], matrix[5], matrix[7];
  GTIF* keys = GTIFNew(tiff);
  GTIFKeyGet(keys, ProjectedCSTypeGeoKey, &read.epsg, 0, 1);
  GTIFKeyGet(keys, GTRasterTypeGeoKey, &read.raster_type, 0, 1);
  GTIFFree(keys);
  CHECK(TIFFLastDirectory(tiff) == 1);
  XTIFFClose(tiff);
  std::filesystem::remove(path);
  return read;
}

TEST_CASE("layers: a GeoTIFF's pixels lie in UTM where they lie in world, within 5 cm") {
  constexpr double kMaxErrorM = 0.05;
  // Near a zone's edge, near its middle, south, and across the zone's border.
  for (const GeoPoint& origin : {kOrigin,
                                 GeoPoint{-15.8, -47.9, 1100.0},
                                 GeoPoint{47.4, 11.9999, 500.0},
                                 GeoPoint{0.0001, 8.9, 10.0}}) {
    SiteMap site_map = HillMap();
    site_map.map.grid.cell_size_m = 8.0;  // 640 x 480 m
    const LocalFrame frame(origin);
    const GeoTiff read = ReadBack(LayerGeoTiff(site_map, "slope", frame));
    CHECK(read.raster_type == RasterPixelIsArea);
    const int zone = read.epsg % 100;
    CHECK(read.epsg - zone == (origin.latitude_deg >= 0.0 ? 32600 : 32700));
    for (const cv::Point& pixel : {cv::Point(0, 0),
                                   cv::Point(79, 0),
                                   cv::Point(79, 59),
                                   cv::Point(0, 59),
                                   cv::Point(40, 30)}) {
      const Eigen::Vector2d in_utm =
          read.utm_from_pixel * Eigen::Vector3d(pixel.x + 0.5, pixel.y + 0.5, 1.0);
      double latitude_deg = 0.0, longitude_deg = 0.0;
      GeographicLib::UTMUPS::Reverse(
          zone, origin.latitude_deg >= 0.0, in_utm.x(), in_utm.y(), latitude_deg, longitude_deg);
      const Eigen::Vector2d in_world =
          frame.WorldFromGeo({latitude_deg, longitude_deg, origin.altitude_m}).head<2>();
      const Eigen::Vector2d truth = site_map.map.grid.CellCenter(pixel.y, pixel.x);
      CHECK((in_world - truth).norm() < kMaxErrorM);
    }
  }
}

TEST_CASE("layers: GeoTIFF values: altitude, degrees, classes, NaN where unseen") {
  const SiteMap site_map = HillMap();
  const LocalFrame frame(kOrigin);
  const auto read = [&](const char* name) {
    return ReadBack(LayerGeoTiff(site_map, name, frame)).values;
  };
  const cv::Mat1f elevation = read("elevation"), hazard = read("hazard"), grass = read("grass");
  CHECK(elevation(12, 65) == doctest::Approx(464.0).epsilon(1e-5));
  CHECK(std::isnan(elevation(58, 2)));
  CHECK(std::isnan(read("distance")(58, 2)));
  CHECK(read("slope")(12, 71) > 10.0f);
  for (int row = 0; row < kHillRows; ++row) {
    for (int col = 0; col < kHillCols; ++col) {
      REQUIRE(hazard(row, col) == site_map.layers.hazard(row, col));
      const float value = grass(row, col);
      REQUIRE((std::isnan(value) || value == 0.0f || value == 1.0f));
    }
  }
  CHECK(hazard(58, 2) == 2.0f);
  CHECK(grass(30, 20) == 1.0f);
  CHECK(grass(30, 75) == 0.0f);
  CHECK_THROWS_AS(LayerGeoTiff(SiteMap{}, "slope", frame), std::invalid_argument);
}

}  // namespace
}  // namespace freelsd
