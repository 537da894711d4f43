#include <cmath>
#include <random>

#include <doctest/doctest.h>

#include "api/stored/map/map.h"
#include "tests/api/export/layers/hill_map.h"

namespace freelsd {
namespace {

bool IsSame(const cv::Mat1f& a, const cv::Mat1f& b) {
  return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin(), [](float x, float y) {
           return x == y || (std::isnan(x) && std::isnan(y));
         });
}

bool IsSame(const cv::Mat1b& a, const cv::Mat1b& b) {
  return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin());
}

MapRasters Hill() {
  const SiteMap hill = HillMap();
  SiteMap rounded = Rounded(hill.map, hill.layers);
  rounded.layers = WithLimits(rounded.map, rounded.layers, {}, {});
  MapRasters rasters{rounded, cv::Mat1b(kHillRows, kHillCols, uchar{7})};
  rasters.cues = {{"views", cv::Mat_<int8_t>(kHillRows, kHillCols, int8_t{40})},
                  {"fence", cv::Mat_<int8_t>(kHillRows, kHillCols, int8_t{0})}};
  rasters.cues[1].steps(3, 4) = CueSteps::kVeto;
  return rasters;
}

// The hill of HillMap, on its four tiles.
std::vector<std::pair<MapTileIndex, MapRasters>> HillTiles() {
  const MapRasters hill = Hill();
  const auto [first, last] = TilesUnder(hill.site_map.map.grid, 0);
  std::vector<std::pair<MapTileIndex, MapRasters>> tiles;
  for (int row = first.row; row <= last.row; ++row) {
    for (int col = first.col; col <= last.col; ++col) {
      const MapTileIndex index{0, row, col};
      MapRasters tile = UnseenRasters(GridOf(index, 1.0));
      CopyCells(hill, tile);
      tiles.emplace_back(index, tile);
    }
  }
  return tiles;
}

TEST_CASE("map tile: the tiles under a grid are those of its lattice") {
  // North-west corner at east -30, north 40; 80 m to the east and 60 m to the south.
  const auto [first, last] = TilesUnder(HillMap().map.grid, 0);
  CHECK(first == MapTileIndex{0, -1, -1});
  CHECK(last == MapTileIndex{0, 0, 0});
  const Grid grid = GridOf({1, -1, 2}, 0.5);
  CHECK(grid.cell_size_m == 1.0);
  CHECK(grid.north_west_in_world == Eigen::Vector2d(256.0, 128.0));
  CHECK(TilesUnder(grid, 0).first == MapTileIndex{0, -1, 2});
  CHECK(TilesUnder(GridOf({0, -3, 5}, 1.0), 1).first == MapTileIndex{1, -2, 2});
}

TEST_CASE("map tile: a map that is cut, stored and put together again is the same") {
  const MapRasters hill = Hill();
  MapRasters whole = UnseenRasters(hill.site_map.map.grid);
  MapRasters planning = whole;
  planning = UnseenRasters(hill.site_map.map.grid);
  size_t num_bytes = 0;
  for (const auto& [index, tile] : HillTiles()) {
    const std::string bytes = SerializeTile(tile);
    num_bytes += bytes.size();
    const MapRasters back = DeserializeTile(bytes, GridOf(index, 1.0), TileLayers::kWithCues);
    CHECK(SerializeTile(back) == bytes);
    CHECK(DeserializeTile(bytes, GridOf(index, 1.0), TileLayers::kAll).cues.empty());
    CopyCells(DeserializeTile(bytes, GridOf(index, 1.0), TileLayers::kWithCues), whole);
    CopyCells(DeserializeTile(bytes, GridOf(index, 1.0), TileLayers::kPlanning), planning);
  }
  CHECK(num_bytes < kHillRows * kHillCols * 33 / 4);
  const auto& [map, layers] = whole.site_map;
  CHECK(IsSame(map.elevation, hill.site_map.map.elevation));
  CHECK(IsSame(map.upper, hill.site_map.map.upper));
  CHECK(IsSame(map.standard_deviation, hill.site_map.map.standard_deviation));
  CHECK(IsSame(map.num_points, hill.site_map.map.num_points));
  CHECK(IsSame(layers.slope, hill.site_map.layers.slope));
  CHECK(IsSame(layers.roughness, hill.site_map.layers.roughness));
  CHECK(IsSame(layers.grass, hill.site_map.layers.grass));
  CHECK(IsSame(layers.kind, hill.site_map.layers.kind));
  CHECK(IsSame(layers.hazard, hill.site_map.layers.hazard));
  CHECK(IsSame(whole.coverage, hill.coverage));
  REQUIRE(whole.cues.size() == 2);
  CHECK(whole.cues[0].name == "views");
  CHECK(cv::countNonZero(whole.cues[0].steps != 40) == 0);
  CHECK(whole.cues[1].steps(3, 4) == CueSteps::kVeto);
  CHECK(cv::countNonZero(whole.cues[1].steps) == 1);
  CHECK(cv::norm(layers.distance, hill.site_map.layers.distance, cv::NORM_INF) <= 1.0 / 16.0);
  CHECK(cv::countNonZero(layers.distance > hill.site_map.layers.distance) == 0);
  // What planning needs gives the same hazards.
  const HazardLayers renewed = WithLimits(planning.site_map.map, planning.site_map.layers, {}, {});
  CHECK(IsSame(renewed.hazard, hill.site_map.layers.hazard));
  CHECK(cv::countNonZero(planning.site_map.layers.hazard == kFree) == 0);
}

TEST_CASE("map tile: an upper height without a ground height is kept") {
  MapRasters tile = UnseenRasters(GridOf({0, 0, 0}, 1.0));
  tile.site_map.map.upper(3, 4) = -12.5f;
  tile.site_map.map.elevation(5, 6) = 100.25f;
  tile.site_map.map.upper(5, 6) = 101.0f;
  const MapRasters back =
      DeserializeTile(SerializeTile(tile), GridOf({0, 0, 0}, 1.0), TileLayers::kAll);
  CHECK(back.site_map.map.upper(3, 4) == -12.5f);
  CHECK(std::isnan(back.site_map.map.elevation(3, 4)));
  CHECK(back.site_map.map.elevation(5, 6) == 100.25f);
  CHECK(back.site_map.map.upper(5, 6) == 101.0f);
}

TEST_CASE("map tile: nothing is stored of unseen ground") {
  CHECK(SerializeTile(UnseenRasters(GridOf({0, 0, 0}, 1.0))).empty());
  CHECK_THROWS_AS(SerializeTile(UnseenRasters({{0.0, 0.0}, 1.0, 3, 3})), std::invalid_argument);
}

TEST_CASE("map tile: damage anywhere is detected, and never gives another map") {
  const auto tiles = HillTiles();
  const Grid grid = GridOf(tiles[0].first, 1.0);
  const std::string bytes = SerializeTile(tiles[0].second);
  for (size_t length = 0; length < bytes.size(); length += 7) {
    CHECK_THROWS_AS(DeserializeTile(bytes.substr(0, length), grid, TileLayers::kWithCues),
                    DamagedMap);
  }
  std::mt19937 random(1);
  for (int i = 0; i < 500; ++i) {
    std::string damaged = bytes;
    damaged[8 + random() % (bytes.size() - 8)] ^= static_cast<char>(1 << (random() % 8));
    try {
      const MapRasters back = DeserializeTile(damaged, grid, TileLayers::kWithCues);
      CHECK(SerializeTile(back) == bytes);
    } catch (const DamagedMap&) {
    }
  }
  for (const char version : {1, 9}) {
    std::string other = bytes;
    other[4] = version;
    CHECK_THROWS_WITH_AS(DeserializeTile(other, grid, TileLayers::kAll),
                         doctest::Contains(("version " + std::to_string(version)).c_str()),
                         std::runtime_error);
  }
}

}  // namespace
}  // namespace freelsd
