#include <cmath>
#include <map>
#include <tuple>

#include <doctest/doctest.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "api/export/color_ramp.h"
#include "api/export/map/map_layer.h"
#include "api/export/map/web_mercator.h"
#include "tests/api/export/map/scenes.h"

namespace freelsd {
namespace {

cv::Mat4b DecodePng(const std::string& bytes) {
  const std::vector<uint8_t> buffer(bytes.begin(), bytes.end());
  cv::Mat picture = cv::imdecode(buffer, cv::IMREAD_UNCHANGED);
  // An opaque picture has no alpha.
  if (picture.channels() == 3) cv::cvtColor(picture, picture, cv::COLOR_BGR2BGRA);
  REQUIRE(picture.type() == CV_8UC4);
  REQUIRE(picture.size() == cv::Size(kTileSizePx, kTileSizePx));
  return picture;
}

// The pixels of a zoom, drawn when they are asked for.
class Pyramid {
 public:
  Pyramid(std::string layer,
          std::vector<MapWindow> windows,
          const Scale& scale,
          const LocalFrame& frame)
      : layer_(std::move(layer)), windows_(std::move(windows)), scale_(scale), frame_(frame) {}

  cv::Vec4b At(const Eigen::Vector2d& place_in_world, int zoom) {
    const GeoPoint geo = frame_.GeoFromWorld({place_in_world.x(), place_in_world.y(), 0.0});
    const XyzTile tile = TileAt(geo, zoom);
    const auto key = std::make_tuple(tile.z, tile.x, tile.y);
    if (!tiles_.contains(key)) {
      tiles_[key] = DecodePng(MapTilePng(layer_, tile, windows_, scale_, frame_));
    }
    const Eigen::Vector2d pixel = PixelFromGeo(geo, zoom);
    return tiles_[key](static_cast<int>(pixel.y()) % kTileSizePx,
                       static_cast<int>(std::fmod(pixel.x(), kTileSizePx)));
  }

 private:
  std::string layer_;
  std::vector<MapWindow> windows_;
  Scale scale_;
  LocalFrame frame_;
  std::map<std::tuple<int, int, int>, cv::Mat4b> tiles_;
};

// Of the zoom whose pixels are not larger than the given size.
int ZoomOf(double pixel_size_m, double latitude_deg) {
  int zoom = 0;
  while (PixelSizeM(zoom, latitude_deg) > pixel_size_m) ++zoom;
  return zoom;
}

// Colours of a palette are within 2 of those of the ramp.
void CheckColor(const cv::Vec4b& pixel, const Color& color) {
  REQUIRE(pixel[3] == 255);
  REQUIRE(std::abs(pixel[0] - color[2]) <= 2);
  REQUIRE(std::abs(pixel[1] - color[1]) <= 2);
  REQUIRE(std::abs(pixel[2] - color[0]) <= 2);
}

TEST_CASE("tiles: at the place of every cell a tile has the colour of its value, at every level") {
  // At the middle, across the antimeridian, near the end of the pyramid, in the south.
  for (const LocalFrame& frame : {FrameAt(47.4, 8.55),
                                  FrameAt(10.0, 179.99995),
                                  FrameAt(84.9, 20.0),
                                  FrameAt(-33.0, -179.99999)}) {
    const auto levels = LevelsOf({HillWindow()}, 3);
    for (int level = 0; level < 3; ++level) {
      const MapWindow& window = levels[level][0];
      const Grid& grid = window.site_map.map.grid;
      const int zoom = ZoomOf(0.4 * grid.cell_size_m, frame.origin().latitude_deg);
      for (const char* layer : {"slope", "roughness", "grass", "height_sd", "coverage"}) {
        const Scale scale = *MapScale(layer, window, frame);
        const LayerRaster raster = RasterOf(window, ValueLayerOf(layer));
        Pyramid pyramid(layer, levels[level], scale, frame);
        int num_seen = 0;
        for (int row = 0; row < grid.num_rows; ++row) {
          for (int col = 0; col < grid.num_cols; ++col) {
            const cv::Vec4b pixel = pyramid.At(grid.CellCenter(row, col), zoom);
            const float value = raster.At(row, col);
            if (std::isnan(value)) {
              REQUIRE(pixel[3] == 0);
              continue;
            }
            ++num_seen;
            CheckColor(pixel, RampColor(layer, (value - scale.min) / (scale.max - scale.min)));
          }
        }
        CHECK(num_seen > grid.num_rows * grid.num_cols / 2);
      }
    }
  }
}

TEST_CASE("tiles: elevation is bright on the hill, and lit from the north-west") {
  const LocalFrame frame = FrameAt(47.4, 8.55);
  const MapWindow window = HillWindow();
  const Scale scale = *MapScale("elevation", window, frame);
  CHECK(scale.min == doctest::Approx(452.0).epsilon(1e-4));
  Pyramid pyramid("elevation", {window}, scale, frame);
  const auto brightness = [&](int row, int col) {
    return cv::sum(cv::Mat(pyramid.At(window.site_map.map.grid.CellCenter(row, col), 20)))[0];
  };
  CHECK(brightness(12, 65) > brightness(12, 15) + 100);
  CHECK(brightness(8, 61) > brightness(16, 69));
}

TEST_CASE("tiles: no place looks safer than its cell, at any zoom") {
  const LocalFrame frame = FrameAt(47.4, 8.55);
  const std::vector<MapWindow> windows{
      RandomWindow({{-300.0, 290.0}, 1.0, 500, 400}, {1, 0.0005, 0.0005}),
      RandomWindow({{50.0, 310.0}, 1.0, 450, 300}, {2, 0.0003, 0.001})};
  const auto levels = LevelsOf(windows, 6);
  const CellFinder finder(windows);
  const auto color = [](const Color& rgb) { return cv::Vec4b(rgb[2], rgb[1], rgb[0], 255); };
  const cv::Vec4b free = color(kFreeColor), hazard = color(kHazardColor);
  for (int zoom = 11; zoom <= 20; ++zoom) {
    const int level = LevelOf(TileAt(frame.origin(), zoom), frame, 1.0, 6);
    Pyramid hazards("hazard", levels[level], {0.0, 2.0}, frame);
    Pyramid distances("distance", levels[level], {0.0, 40.0}, frame);
    int num_free = 0;
    for (int y = -220; y < 320; ++y) {
      for (int x = -310; x < 360; ++x) {
        const Eigen::Vector2d place(x + 0.3, y + 0.7);
        const WindowCell cell = finder.At(place);
        const cv::Vec4b pixel = hazards.At(place, zoom);
        num_free += pixel == free;
        if (!cell.window) {
          REQUIRE(pixel != free);
          continue;
        }
        const HazardLayers& layers = cell.window->site_map.layers;
        const uint8_t value = layers.hazard(cell.row, cell.col);
        REQUIRE(pixel[3] == 255);
        if (value != kFree) REQUIRE(pixel != free);
        if (value == kHazard) REQUIRE(pixel == hazard);
        // Nor has distance a colour of its ramp there: it shows the same hazards.
        const cv::Vec4b distance = distances.At(place, zoom);
        REQUIRE((pixel == free) == (distance != hazard && distance != color(kUnseenColor)));
      }
    }
    if (zoom >= 16) CHECK(num_free > 100000);
  }
}

TEST_CASE("tiles: the first of two windows that has seen a place shows it") {
  const LocalFrame frame = FrameAt(47.4, 8.55);
  MapWindow first = RandomWindow({{-20.0, 20.0}, 1.0, 40, 40}, {1, 0.0, 0.0});
  MapWindow second = RandomWindow({{0.0, 20.0}, 1.0, 40, 40}, {2, 0.0, 0.0});
  first.site_map.layers.roughness.setTo(0.2f);
  second.site_map.layers.roughness.setTo(0.8f);
  const cv::Rect gap(30, 10, 5, 5);
  first.site_map.layers.hazard(gap).setTo(kUnseen);
  first.site_map.layers.roughness(gap).setTo(std::nanf(""));
  Pyramid pyramid("roughness", {first, second}, {0.0, 1.0}, frame);
  CheckColor(pyramid.At({-10.5, 0.5}, 20), RampColor("roughness", 0.2));
  CheckColor(pyramid.At({5.5, 0.5}, 20), RampColor("roughness", 0.2));
  CheckColor(pyramid.At({12.5, 7.5}, 20), RampColor("roughness", 0.8));
  CheckColor(pyramid.At({30.5, 0.5}, 20), RampColor("roughness", 0.8));
  Pyramid hazard("hazard", {first, second}, {0.0, 2.0}, frame);
  CheckColor(hazard.At({12.5, 7.5}, 20), kFreeColor);
}

TEST_CASE("tiles: outside the map they are transparent, also on the other side of the earth") {
  const LocalFrame frame = FrameAt(47.4, 8.55);
  const std::vector<MapWindow> windows{HillWindow()};
  for (const XyzTile& tile : {TileAt({47.41, 8.55, 0.0}, 17),
                              TileAt({-47.4, -171.45, 0.0}, 17),
                              TileAt({-47.4, -171.45, 0.0}, 1),
                              XyzTile{20, 0, 0}}) {
    for (const std::string& layer : MapLayerNames()) {
      const std::string png = layer == "photo"
                                  ? PhotoTilePng(tile, {}, frame)
                                  : MapTilePng(layer, tile, windows, {0.0, 1.0}, frame);
      CHECK(cv::sum(DecodePng(png))[3] == 0.0);
    }
  }
  CHECK(cv::sum(DecodePng(MapTilePng("hazard", {0, 0, 0}, windows, {0.0, 2.0}, frame)))[3] > 0.0);
  CHECK(cv::sum(DecodePng(MapTilePng("hazard", {0, 0, 0}, {}, {0.0, 2.0}, frame)))[3] == 0.0);
}

TEST_CASE("tiles: a photo's pixels are where they were seen") {
  const LocalFrame frame = FrameAt(47.4, 8.55);
  PhotoWindow photo{{{-20.0, 20.0}, 0.1, 400, 400}, cv::Mat4b(400, 400)};
  for (int row = 0; row < 400; ++row) {
    for (int col = 0; col < 400; ++col) {
      photo.pixels(row, col) = cv::Vec4b(
          static_cast<uint8_t>(row / 2), static_cast<uint8_t>(col / 2), 100, col < 300 ? 255 : 0);
    }
  }
  const PhotoWindow coarse = Coarser(photo);
  for (const auto& [window, zoom] : {std::pair(photo, 22), std::pair(coarse, 20)}) {
    const XyzTile tile = TileAt(frame.origin(), zoom);
    const cv::Mat4b picture = DecodePng(PhotoTilePng(tile, {window}, frame));
    const std::string jpeg = PhotoTileJpeg(tile, {window}, frame);
    const cv::Mat3b flat =
        cv::imdecode(std::vector<uint8_t>(jpeg.begin(), jpeg.end()), cv::IMREAD_COLOR);
    REQUIRE(flat.size() == picture.size());
    int num_seen = 0;
    for (int row = 0; row < kTileSizePx; ++row) {
      for (int col = 0; col < kTileSizePx; ++col) {
        const GeoPoint geo = GeoFromPixel(
            Eigen::Vector2d(tile.x, tile.y) * kTileSizePx + Eigen::Vector2d(col + 0.5, row + 0.5),
            zoom);
        const Eigen::Vector3d place =
            frame.WorldFromGeo({geo.latitude_deg, geo.longitude_deg, 450});
        if (std::abs(place.x()) > 19.5 || std::abs(place.y()) > 19.5) continue;
        const bool is_seen = place.x() < 10.0;
        if (std::abs(place.x() - 10.0) > 0.4) REQUIRE(picture(row, col)[3] == (is_seen ? 255 : 0));
        if (picture(row, col)[3] < 255) continue;
        ++num_seen;
        // Half a step of colour is 0.1 m.
        REQUIRE(std::abs(picture(row, col)[0] - (20.0 - place.y()) * 5.0) < 2.5);
        REQUIRE(std::abs(picture(row, col)[1] - (place.x() + 20.0) * 5.0) < 2.5);
        if (place.x() < 9.0) REQUIRE(std::abs(flat(row, col)[0] - picture(row, col)[0]) < 20);
      }
    }
    CHECK(num_seen > 3000);
  }
}

TEST_CASE("tiles: no such layer, a scale without extent, and rasters of other sizes are refused") {
  const LocalFrame frame = FrameAt(47.4, 8.55);
  const XyzTile tile = TileAt(frame.origin(), 18);
  const std::vector<MapWindow> windows{HillWindow()};
  for (const char* layer : {"photo", "", "Hazard", "danger", "../hazard"}) {
    CHECK_THROWS_AS(MapTilePng(layer, tile, windows, {}, frame), std::invalid_argument);
    CHECK_THROWS_AS(MapLegendPng(layer, {}), std::invalid_argument);
    CHECK_THROWS_AS(MapScale(layer, windows[0], frame), std::invalid_argument);
  }
  CHECK_THROWS_AS(MapTilePng("slope", tile, windows, {1.0, 1.0}, frame), std::invalid_argument);
  CHECK_THROWS_AS(MapTilePng("slope", {2, 4, 0}, windows, {}, frame), std::invalid_argument);
  MapWindow bad = HillWindow();
  bad.site_map.layers.slope = cv::Mat1f(3, 3);
  CHECK_THROWS_AS(MapTilePng("slope", tile, {bad}, {}, frame), std::invalid_argument);
  PhotoWindow photo{{{0.0, 0.0}, 0.1, 4, 4}, cv::Mat4b(4, 5)};
  CHECK_THROWS_AS(PhotoTilePng(tile, {photo}, frame), std::invalid_argument);
}

TEST_CASE("map: legends exist for every layer with values") {
  for (const std::string& layer : MapLayerNames()) {
    if (layer == "photo") continue;
    const std::string png = MapLegendPng(layer, {400.0, 480.0});
    CHECK(cv::imdecode(std::vector<uint8_t>(png.begin(), png.end()), cv::IMREAD_COLOR).cols > 100);
  }
}

}  // namespace
}  // namespace freelsd
