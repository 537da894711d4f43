#include <cmath>
#include <filesystem>

#include <GeographicLib/UTMUPS.hpp>
#include <doctest/doctest.h>
#include <geotiff/geotiff.h>
#include <geotiff/geotiffio.h>
#include <geotiff/xtiffio.h>
#include <unistd.h>

#include "api/api.h"
#include "api/export/map/map_layer.h"
#include "api/export/map/pixel_places.h"
#include "tests/api/export/map/scenes.h"

namespace freelsd {
namespace {

// A file's pictures: the whole one, then its overviews.
struct GeoTiff {
  std::vector<cv::Mat> pictures;
  Eigen::Vector2d north_west;
  double pixel_size_m = 0.0;
  unsigned short epsg = 0;
  int num_tiles = 0;
  int num_stored_tiles = 0;
};

// Tiles that are left out are read as by GDAL.
cv::Mat ReadPicture(TIFF* tiff, GeoTiff& read) {
  uint32_t width = 0, height = 0, tile_px = 0;
  uint16_t bits = 0, samples = 0;
  TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &width);
  TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &height);
  TIFFGetField(tiff, TIFFTAG_BITSPERSAMPLE, &bits);
  TIFFGetField(tiff, TIFFTAG_SAMPLESPERPIXEL, &samples);
  TIFFGetField(tiff, TIFFTAG_TILEWIDTH, &tile_px);
  REQUIRE(TIFFIsTiled(tiff));
  REQUIRE(tile_px == 256);
  REQUIRE(bits * samples == 32);
  cv::Mat picture(
      static_cast<int>(height), static_cast<int>(width), bits == 32 ? CV_32FC1 : CV_8UC4);
  cv::Mat tile(256, 256, picture.type());
  for (int y = 0; y < picture.rows; y += 256) {
    for (int x = 0; x < picture.cols; x += 256) {
      ++read.num_tiles;
      if (TIFFGetStrileByteCount(tiff, TIFFComputeTile(tiff, x, y, 0, 0)) > 0) {
        ++read.num_stored_tiles;
        REQUIRE(TIFFReadTile(tiff, tile.data, x, y, 0, 0) > 0);
      } else {
        tile.setTo(cv::Scalar::all(bits == 32 ? std::nan("") : 0.0));
      }
      const cv::Rect part = cv::Rect(x, y, 256, 256) & cv::Rect(0, 0, picture.cols, picture.rows);
      tile(cv::Rect(cv::Point(0, 0), part.size())).copyTo(picture(part));
    }
  }
  return picture;
}

GeoTiff ReadBack(const std::filesystem::path& path) {
  TIFFSetWarningHandler(nullptr);  // of GDAL's tag for no data, which plain libtiff does not know
  TIFF* tiff = XTIFFOpen(path.c_str(), "r");
  REQUIRE(tiff != nullptr);
  GeoTiff read;
  uint16_t count = 0;
  double *scale = nullptr, *tie = nullptr;
  REQUIRE(TIFFGetField(tiff, TIFFTAG_GEOPIXELSCALE, &count, &scale) == 1);
  read.pixel_size_m = scale[0];
  CHECK(scale[1] == scale[0]);
  REQUIRE(TIFFGetField(tiff, TIFFTAG_GEOTIEPOINTS, &count, &tie) == 1);
  read.north_west = {tie[3], tie[4]};
  GTIF* keys = GTIFNew(tiff);
  GTIFKeyGet(keys, ProjectedCSTypeGeoKey, &read.epsg, 0, 1);
  GTIFFree(keys);
  do {
    uint32_t kind = 0;
    TIFFGetField(tiff, TIFFTAG_SUBFILETYPE, &kind);
    CHECK(kind == (read.pictures.empty() ? 0 : FILETYPE_REDUCEDIMAGE));
    read.pictures.push_back(ReadPicture(tiff, read));
  } while (TIFFReadDirectory(tiff) == 1);
  XTIFFClose(tiff);
  return read;
}

std::filesystem::path TemporaryFile(const std::string& name) {
  return std::filesystem::temp_directory_path() /
         ("freelsd_map_" + std::to_string(getpid()) + "_" + name);
}

template <typename Source>
GeoTiff WrittenAndRead(const std::string& layer, const Source& source, const LocalFrame& frame) {
  const auto path = TemporaryFile(layer + ".tif");
  if constexpr (std::is_same_v<Source, MapSource>) {
    WriteLayerGeoTiff(path, layer, source, frame);
  } else {
    WritePhotoGeoTiff(path, source, frame);
  }
  GeoTiff read = ReadBack(path);
  std::filesystem::remove(path);
  return read;
}

// Place of a pixel's position, without the conversions under test.
Eigen::Vector2d PlaceOf(const GeoTiff& tiff, double col, double row, const LocalFrame& frame) {
  GeoPoint geo;
  GeographicLib::UTMUPS::Reverse(tiff.epsg % 100 == 61 ? 0 : tiff.epsg % 100,
                                 tiff.epsg < 32700,
                                 tiff.north_west.x() + col * tiff.pixel_size_m,
                                 tiff.north_west.y() - row * tiff.pixel_size_m,
                                 geo.latitude_deg,
                                 geo.longitude_deg);
  return PlaceInWorld(geo, frame);
}

TEST_CASE("map: every pixel of a GeoTIFF has the value of the cell at its place") {
  const MapSource source = TwoWindows();
  const auto windows = source.windows_of({}, 0);
  const CellFinder finder(windows);
  for (const LocalFrame& frame : {FrameAt(47.4, 11.99), FrameAt(-33.0, 179.9999)}) {
    for (const char* layer : {"roughness", "elevation", "slope", "grass", "coverage"}) {
      const GeoTiff tiff = WrittenAndRead(layer, source, frame);
      CHECK(tiff.epsg == (frame.origin().latitude_deg > 0 ? 32632 : 32760));
      CHECK(tiff.pixel_size_m == 1.0);
      const cv::Mat1f values = tiff.pictures[0];
      int num_seen = 0, num_wrong = 0;
      for (int row = 0; row < values.rows; row += 3) {
        for (int col = 0; col < values.cols; ++col) {
          const Eigen::Vector2d place = PlaceOf(tiff, col + 0.5, row + 0.5, frame);
          const WindowCell cell = finder.At(place);
          if (!cell.window) {
            REQUIRE(std::isnan(values(row, col)));
            continue;
          }
          float expected = RasterOf(*cell.window, ValueLayerOf(layer)).At(cell.row, cell.col);
          if (layer == std::string("elevation")) expected += 450.0f;
          if (layer == std::string("grass")) {
            expected = expected >= cell.window->site_map.layers.min_grass_posterior ? 1.0f : 0.0f;
          }
          const float value = values(row, col);
          const bool is_right =
              std::isnan(expected) ? std::isnan(value) : std::abs(value - expected) < 0.02f;
          // Places within millimetres of a cell's edge.
          num_wrong += !is_right;
          ++num_seen;
        }
      }
      CHECK(num_seen > 80000);
      CHECK(num_wrong < 0.001 * num_seen);
    }
  }
}

TEST_CASE("map: no pixel of a GeoTIFF or of its overviews is safer than a place in it") {
  const MapSource source = TwoWindows();
  const auto windows = source.windows_of({}, 0);
  const CellFinder finder(windows);
  // The last one has a grid that is turned by 40 degrees.
  for (const LocalFrame& frame : {FrameAt(47.4, 11.99), FrameAt(87.0, 40.0)}) {
    const GeoTiff hazard = WrittenAndRead("hazard", source, frame);
    const GeoTiff distance = WrittenAndRead("distance", source, frame);
    REQUIRE(hazard.pictures.size() > 1);
    for (size_t level = 0; level < hazard.pictures.size(); ++level) {
      const cv::Mat1f hazards = hazard.pictures[level], distances = distance.pictures[level];
      const cv::Mat1f& fine = hazard.pictures[0];
      // GDAL computes the size of an overview's pixels from these numbers.
      REQUIRE(fine.cols == hazards.cols << level);
      REQUIRE(fine.rows == hazards.rows << level);
      const double scale = std::ldexp(1.0, static_cast<int>(level));
      int num_free = 0, num_safer = 0, num_places = 0;
      for (double y = 0.25; y < fine.rows; y += 0.7) {
        for (double x = 0.25; x < fine.cols; x += 0.7) {
          const int row = static_cast<int>(y / scale), col = static_cast<int>(x / scale);
          const float value = hazards(row, col), metres = distances(row, col);
          num_free += value == 0.0f;
          REQUIRE((value == 0.0f) == (metres > 0.0f));
          REQUIRE((value == 1.0f) == (metres == 0.0f));
          const WindowCell cell = finder.At(PlaceOf(hazard, x, y, frame));
          const bool is_free =
              cell.window && cell.window->site_map.layers.hazard(cell.row, cell.col) == kFree;
          ++num_places;
          // Corners of cells that reach over the edge of a turned pixel, between its steps.
          num_safer += value == 0.0f && !is_free;
        }
      }
      CHECK(num_free > (level == 0 ? 100000 : 0));
      CHECK(num_safer <= 0.0005 * num_places);
    }
  }
}

TEST_CASE("map: a GeoTIFF of a photo has its colours, and nothing where nothing is seen") {
  const LocalFrame frame = FrameAt(47.4, 8.55);
  PhotoWindow photo{{{-60.0, 60.0}, 0.1, 1200, 1200}, cv::Mat4b(1200, 1200)};
  for (int row = 0; row < 1200; ++row) {
    for (int col = 0; col < 1200; ++col) {
      photo.pixels(row, col) = cv::Vec4b(static_cast<uint8_t>(row / 6),
                                         static_cast<uint8_t>(col / 6),
                                         100,
                                         row > 600 && col > 600 ? 0 : 255);
    }
  }
  const std::vector<std::vector<PhotoWindow>> levels{
      {photo}, {Coarser(photo)}, {Coarser(Coarser(photo))}};
  const PhotoSource source{BoxOf(photo.grid), 0.1, 3, SourceOf(levels), {}};
  const GeoTiff tiff = WrittenAndRead("photo", source, frame);
  REQUIRE(tiff.pictures.size() == 3);
  for (size_t level = 0; level < 3; ++level) {
    const cv::Mat4b rgba = tiff.pictures[level];
    const double scale = std::ldexp(1.0, static_cast<int>(level));
    int num_seen = 0;
    for (int row = 0; row < rgba.rows; row += 2) {
      for (int col = 0; col < rgba.cols; col += 2) {
        const Eigen::Vector2d place =
            PlaceOf(tiff, (col + 0.5) * scale, (row + 0.5) * scale, frame);
        const double east = place.x() + 60.0, south = 60.0 - place.y();
        if (east < 0.4 || south < 0.4 || east > 119.6 || south > 119.6) continue;
        if (east > 60.5 && south > 60.5) REQUIRE(rgba(row, col)[3] == 0);
        if (east > 59.5 && south > 59.5) continue;
        ++num_seen;
        REQUIRE(rgba(row, col)[3] == 255);
        REQUIRE(rgba(row, col)[0] == 100);
        REQUIRE(std::abs(rgba(row, col)[1] - east / 0.6) < 1.6);
        REQUIRE(std::abs(rgba(row, col)[2] - south / 0.6) < 1.6);
      }
    }
    CHECK(num_seen > 10000);
  }
}

// Two maps of 200 m by 320 m, 12 km apart along both axes. Counts how often windows are asked for.
MapSource FarApart(int& num_asked) {
  const std::vector<MapWindow> windows{RandomWindow({{-6000.0, -5680.0}, 1.0, 320, 200}, {1}),
                                       RandomWindow({{6000.0, 6000.0}, 1.0, 320, 200}, {2})};
  MapSource source{{{-6000.0, -6000.0}, {6200.0, 6000.0}},
                   1.0,
                   kNumLevels,
                   SourceOf(LevelsOf(windows, kNumLevels)),
                   {}};
  for (const MapWindow& window : windows) source.parts.push_back(BoxOf(window.site_map.map.grid));
  source.windows_of = [&num_asked, all = source.windows_of](const WorldBox& box, int level) {
    ++num_asked;
    return all(box, level);
  };
  return source;
}

TEST_CASE("map: a GeoTIFF stores only tiles that meet a part of the map, in overviews too") {
  // Tiles that may meet one of the maps at a level, for each map.
  constexpr int kMaxNumTilesPerMap = 9;
  const LocalFrame frame = FrameAt(47.4, 11.0);
  int num_asked = 0;
  const MapSource source = FarApart(num_asked);
  const GeoTiff tiff = WrittenAndRead("hazard", source, frame);
  const int num_levels = static_cast<int>(tiff.pictures.size());
  REQUIRE(num_levels == kNumLevels);
  CHECK(tiff.num_tiles > 2000);
  CHECK(tiff.num_stored_tiles <= 2 * kMaxNumTilesPerMap * num_levels);
  CHECK(num_asked <= tiff.num_stored_tiles);
  const auto windows = source.windows_of({}, 0);
  for (int level = 0; level < num_levels; ++level) {
    const cv::Mat1f values = tiff.pictures[level];
    const double scale = std::ldexp(1.0, level);
    int num_seen = 0;
    for (int row = 0; row < values.rows; ++row) {
      for (int col = 0; col < values.cols; ++col) num_seen += !std::isnan(values(row, col));
    }
    // Pixels at the edges show a part of a map.
    CHECK(num_seen * scale * scale >= 2 * 320 * 200);
    CHECK(num_seen * scale * scale <= 2 * (320 + 4 * scale + 12) * (200 + 4 * scale + 20));
  }
}

TEST_CASE("map: a GeoTIFF with too many pixels or tiles is refused before anything is drawn") {
  const LocalFrame frame = FrameAt(47.4, 11.0);
  int num_asked = 0;
  const MapSource source = FarApart(num_asked);
  const auto path = TemporaryFile("refused.tif");
  GeoTiffOptions few_pixels, few_tiles;
  few_pixels.max_num_pixels = 100e3;
  few_tiles.max_num_tiles = 1000;
  for (const GeoTiffOptions& options : {few_pixels, few_tiles}) {
    try {
      WriteLayerGeoTiff(path, "slope", source, frame, options);
      FAIL("it was written");
    } catch (const ApiError& error) {
      CHECK(error.code() == "TooLarge");
      CHECK(error.http_status() == 413);
      CHECK(error.observed > error.limit);
    }
  }
  CHECK(num_asked == 0);
  CHECK_FALSE(std::filesystem::exists(path));
}

TEST_CASE("map: the writing of a GeoTIFF stops when the caller no longer wants it") {
  const auto path = TemporaryFile("stopped.tif");
  int num_asked = 0, num_blocks = 0;
  MapSource source = FarApart(num_asked);
  source.windows_of = [&num_blocks, windows_of = source.windows_of](const WorldBox& box,
                                                                    int level) {
    if (++num_blocks == 3) throw ApiError("ShuttingDown", "the server is stopping");
    return windows_of(box, level);
  };
  CHECK_THROWS_AS(WriteLayerGeoTiff(path, "slope", source, FrameAt(47.4, 11.0)), ApiError);
  CHECK(num_asked == 2);
  std::filesystem::remove(path);
}

TEST_CASE("map: a GeoTIFF that cannot be written is an error, and so is a wrong layer") {
  const LocalFrame frame = FrameAt(47.4, 8.55);
  MapSource source = TwoWindows();
  TIFFSetErrorHandler(nullptr);
  CHECK_THROWS_AS(WriteLayerGeoTiff("/nowhere/a.tif", "slope", source, frame), std::runtime_error);
  CHECK_THROWS_AS(WriteLayerGeoTiff("/nowhere/a.tif", "photo", source, frame),
                  std::invalid_argument);
  CHECK_THROWS_AS(MapKmz("a", "photo", source, {}, frame), std::invalid_argument);
  source.extent = {};
  CHECK_THROWS_AS(WriteLayerGeoTiff("/nowhere/a.tif", "slope", source, frame),
                  std::invalid_argument);
}

}  // namespace
}  // namespace freelsd
