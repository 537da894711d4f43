#include "api/export/map/web_mercator.h"

#include <cmath>

#include <doctest/doctest.h>

#include "api/export/map/pixel_places.h"
#include "tests/api/export/map/scenes.h"

namespace freelsd {
namespace {

TEST_CASE("tiles: bounds are those that the manual of mercantile prints") {
  const GeoBounds bounds = BoundsOf({10, 486, 332});
  CHECK(bounds.west_deg == doctest::Approx(-9.140625).epsilon(1e-12));
  CHECK(bounds.south_deg == doctest::Approx(53.12040528310657).epsilon(1e-12));
  CHECK(bounds.east_deg == doctest::Approx(-8.7890625).epsilon(1e-12));
  CHECK(bounds.north_deg == doctest::Approx(53.33087298301705).epsilon(1e-12));
  const GeoBounds world = BoundsOf({0, 0, 0});
  CHECK(world.west_deg == -180.0);
  CHECK(world.east_deg == 180.0);
  CHECK(world.north_deg == doctest::Approx(85.0511287798066).epsilon(1e-12));
  CHECK(world.south_deg == doctest::Approx(-85.0511287798066).epsilon(1e-12));
}

TEST_CASE("tiles: a place is in the tile that the formula of OpenStreetMap gives") {
  const auto check = [](double latitude_deg, double longitude_deg, const XyzTile& expected) {
    const XyzTile tile = TileAt({latitude_deg, longitude_deg, 0.0}, expected.z);
    CHECK(tile.x == expected.x);
    CHECK(tile.y == expected.y);
  };
  check(53.3, -9.0, {10, 486, 332});
  check(47.3769, 8.5417, {17, 68645, 45899});
  check(-33.8568, 151.2153, {15, 30147, 19662});
  // At the edges of the pyramid.
  check(85.0, 179.99999, {10, 1023, 1});
  check(-85.0, -180.0, {10, 0, 1022});
  check(89.0, 180.0, {10, 1023, 0});
}

TEST_CASE("tiles: one that does not exist is refused with its name") {
  CHECK_THROWS_WITH_AS(BoundsOf({31, 0, 0}), "tile.z = 31: must be 0 to 30", std::invalid_argument);
  CHECK_THROWS_WITH_AS(BoundsOf({3, 8, 0}), "tile.x = 8: must be 0 to 7", std::invalid_argument);
  CHECK_THROWS_AS(BoundsOf({3, 0, -1}), std::invalid_argument);
  CHECK_THROWS_AS(BoundsOf({-1, 0, 0}), std::invalid_argument);
}

TEST_CASE(
    "tiles: the world box holds every place of the tile, and no more than some pixels around") {
  for (const double latitude_deg : {0.0, 47.4, -33.0, 84.0}) {
    for (const int zoom : {11, 14, 17, 21}) {
      const LocalFrame frame = FrameAt(latitude_deg, 179.9999);
      // Beyond the antimeridian from the origin.
      const XyzTile tile = TileAt({latitude_deg + 0.002, -179.9998, 0.0}, zoom);
      const GeoBounds bounds = BoundsOf(tile);
      const auto box = WorldBoxOf(tile, frame);
      REQUIRE(box);
      const double size_m = kTileSizePx * PixelSizeM(zoom, latitude_deg);
      CHECK((box->max_in_world - box->min_in_world).maxCoeff() < 1.2 * size_m);
      for (double share = 0.0; share <= 1.0; share += 0.01) {
        const double latitude = bounds.south_deg + share * (bounds.north_deg - bounds.south_deg);
        const double longitude = bounds.west_deg + share * (bounds.east_deg - bounds.west_deg);
        for (const GeoPoint& geo : {GeoPoint{latitude, bounds.west_deg, 0.0},
                                    GeoPoint{latitude, bounds.east_deg, 0.0},
                                    GeoPoint{bounds.south_deg, longitude, 0.0},
                                    GeoPoint{bounds.north_deg, longitude, 0.0}}) {
          const Eigen::Vector2d place = PlaceInWorld(geo, frame);
          REQUIRE((place.array() > box->min_in_world.array()).all());
          REQUIRE((place.array() < box->max_in_world.array()).all());
        }
      }
    }
  }
}

TEST_CASE("tiles: one far away, also on the other side of the earth, needs no windows") {
  const LocalFrame frame = FrameAt(47.4, 8.55);
  CHECK_FALSE(WorldBoxOf(TileAt({46.0, 8.55, 0.0}, 12), frame));
  CHECK_FALSE(WorldBoxOf(TileAt({-47.4, -171.45, 0.0}, 12), frame));
  const auto box = WorldBoxOf({0, 0, 0}, frame);
  REQUIRE(box);
  CHECK(box->max_in_world.x() > 50e3);
  CHECK(box->max_in_world.x() < 1000e3);
}

TEST_CASE("tiles: the coarsest level is read whose cells are not larger than the pixels") {
  const LocalFrame frame = FrameAt(47.4, 8.55);
  for (int zoom = 8; zoom < 22; ++zoom) {
    const int level = LevelOf(TileAt(frame.origin(), zoom), frame, 1.0, 8);
    const double pixel_m = PixelSizeM(zoom, 47.4);
    if (level > 0) CHECK(std::ldexp(1.0, level) <= pixel_m);
    if (level < 7) CHECK(std::ldexp(1.0, level + 1) > pixel_m);
  }
  CHECK(LevelOf(TileAt(frame.origin(), 20), frame, 1.0, 8) == 0);
  CHECK(LevelOf(TileAt(frame.origin(), 5), frame, 1.0, 8) == 7);
}

TEST_CASE("tiles: places between the projected ones are right within a tenth of the finest cells") {
  for (const double latitude_deg : {0.0, 47.4, -60.0, 84.9}) {
    for (int zoom = 4; zoom < 23; ++zoom) {
      const LocalFrame frame = FrameAt(latitude_deg, 8.55);
      const XyzTile tile = TileAt(frame.origin(), zoom);
      const Eigen::Vector2d corner = Eigen::Vector2d(tile.x, tile.y) * kTileSizePx;
      const double pixel_m = PixelSizeM(zoom, latitude_deg);
      const auto geo = [&](const Eigen::Vector2d& position) {
        return GeoFromPixel(corner + position, zoom);
      };
      // As much of the tile as a map may cover.
      const Eigen::Vector2d origin_px = PixelFromGeo(frame.origin(), zoom) - corner;
      const int reach_px = std::clamp(static_cast<int>(20e3 / pixel_m), 1, 256);
      const cv::Rect box = cv::Rect(0, 0, kTileSizePx, kTileSizePx) &
                           cv::Rect(static_cast<int>(origin_px.x()) - reach_px,
                                    static_cast<int>(origin_px.y()) - reach_px,
                                    2 * reach_px,
                                    2 * reach_px);
      const PixelPlaces places({geo, pixel_m}, box, frame);
      for (double row = box.y + 0.5; row < box.y + box.height; row += 7.0) {
        const auto line = places.Row({box.x + 0.5, row}, 1.0, box.width);
        for (int col = 0; col < box.width; ++col) {
          const Eigen::Vector2d exact = PlaceInWorld(geo({box.x + col + 0.5, row}), frame);
          REQUIRE((line[col] - exact).norm() < 0.05 * pixel_m);
        }
      }
    }
  }
}

}  // namespace
}  // namespace freelsd
