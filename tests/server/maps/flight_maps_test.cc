#include <cmath>
#include <filesystem>

#include <doctest/doctest.h>

#include "server/maps/maps.h"
#include "tests/server/meadow_map.h"

namespace freelsd {
namespace {

// Heights that tell each cell from all others.
SiteMap Slope() {
  SiteMap slope = Meadow();
  for (int row = 0; row < slope.map.elevation.rows; ++row) {
    for (int col = 0; col < slope.map.elevation.cols; ++col) {
      const float height = static_cast<float>(row) / 128.0f + static_cast<float>(col) / 64.0f;
      slope.map.elevation(row, col) = height;
      slope.map.upper(row, col) = height + 0.5f;
    }
  }
  return slope;
}

TEST_CASE("flight maps: any window of a stored map has the cells of the map, and the rest unseen") {
  const TemporaryFolder folder;
  Storage storage(StorageAt(folder.path()));
  const SiteMap slope = Slope();
  StoreMeadowMap(storage, slope);
  FlightMaps maps(size_t{1} << 20);  // one tile or two
  const auto map = maps.Find(storage, "f/1");
  REQUIRE(map);
  CHECK(map->head.num_levels == 4);
  CHECK_FALSE(maps.Find(storage, "f/2"));
  const Grid window{{-350.0, 320.0}, 1.0, 700, 400};
  const MapRasters read = maps.Read(storage, *map, 0, window, TileLayers::kAll);
  size_t num_wrong = 0;
  for (int row = 0; row < window.num_rows; ++row) {
    for (int col = 0; col < window.num_cols; ++col) {
      const auto cell = slope.map.grid.CellAt(window.CellCenter(row, col));
      const float height = read.site_map.map.elevation(row, col);
      num_wrong += cell ? height != slope.map.elevation(*cell) : !std::isnan(height);
    }
  }
  CHECK(num_wrong == 0);
  CHECK(read.coverage(100, 100) == 2);
  CHECK(read.site_map.layers.hazard(0, 0) == kUnseen);
  CHECK(read.site_map.layers.hazard(100, 100) == kFree);
}

TEST_CASE("flight maps: a coarse level keeps the highest, and is free only if all cells are") {
  const TemporaryFolder folder;
  Storage storage(StorageAt(folder.path()));
  SiteMap meadow = Meadow();
  meadow.map.upper(301, 301) = 9.0f;
  meadow.layers.hazard(301, 301) = kHazard;
  meadow.map.elevation(200, 200) = meadow.map.upper(200, 200) = std::nanf("");
  meadow.map.num_points(200, 200) = std::nanf("");
  meadow.layers.hazard(200, 200) = kUnseen;
  StoreMeadowMap(storage, meadow);
  FlightMaps maps(size_t{1} << 24);
  const auto map = maps.Find(storage, "f/1");
  REQUIRE(map);
  const Grid grid = map->GridAt(1);
  CHECK(grid.num_rows == 300);
  const MapRasters coarse = maps.Read(storage, *map, 1, grid, TileLayers::kAll);
  CHECK(coarse.site_map.map.upper(150, 150) == 9.0f);
  CHECK(coarse.site_map.layers.hazard(150, 150) == kHazard);
  CHECK(coarse.site_map.layers.hazard(100, 100) == kUnseen);
  CHECK(coarse.site_map.map.upper(100, 100) == doctest::Approx(0.1).epsilon(0.1));
  CHECK(std::isnan(coarse.site_map.map.num_points(100, 100)));
  CHECK(coarse.site_map.layers.hazard(10, 10) == kFree);
}

TEST_CASE(
    "flight maps: a damaged tile is read from the copy, and without one only its ground is lost") {
  for (const bool is_copy_damaged : {false, true}) {
    const TemporaryFolder folder;
    const std::filesystem::path copy = folder.path() / "data/recall.db",
                                kept = folder.path() / "kept";
    {
      Storage storage(StorageAt(folder.path() / "data"));
      StoreMeadowMap(storage, Meadow());
    }
    std::filesystem::copy_file(copy, kept);
    Storage(StorageAt(folder.path() / "data")).maps.StageTiles("f/1", {{{0, 0, 0}, "no tile"}}, {});
    if (!is_copy_damaged) {
      std::filesystem::copy_file(kept, copy, std::filesystem::copy_options::overwrite_existing);
    }
    const Storage storage(StorageAt(folder.path() / "data"));
    FlightMaps maps(size_t{1} << 24);
    const auto map = maps.Find(storage, "f/1");
    REQUIRE(map);
    const MapRasters read = maps.Read(storage, *map, 0, map->head.grid, TileLayers::kPlanning);
    // The tile holds the 128 m south-east of the origin.
    CHECK(std::isnan(read.site_map.map.elevation(310, 310)) == is_copy_damaged);
    CHECK(read.site_map.map.elevation(290, 310) == 0.0f);
    CHECK(read.site_map.map.elevation(310, 430) == 0.0f);
    CHECK_FALSE(storage.Notices().empty());
  }
}

TEST_CASE("flight maps: a box larger than the map asks only for photo tiles on the map") {
  const TemporaryFolder folder;
  Storage storage(StorageAt(folder.path()));
  FlightMaps maps(size_t{1} << 24);
  const FlightMapRow row =
      StageMeadowMap(storage, Meadow(), "f", 1600000000000000, PhotoLattice{1.0, 512, 1});
  PutMeadowPicture(storage, row);
  const auto map = maps.Find(storage, row.id);
  REQUIRE(map);
  // The meadow reaches 300 m from the origin to each side.
  const WorldBox world{{-1e7, -1e7}, {1e7, 1e7}}, elsewhere{{301.0, -1e7}, {1e7, 1e7}};
  CHECK(PhotoTilesIn(*map, 0, world) == cv::Rect(-1, -1, 2, 2));
  CHECK(PhotoTilesIn(*map, 0, {{-10.0, 10.0}, {10.0, 20.0}}) == cv::Rect(-1, -1, 2, 1));
  CHECK(PhotoTilesIn(*map, 0, elsewhere).empty());
  CHECK(maps.ReadPhoto(storage, *map, 0, elsewhere).empty());
  const std::vector<PhotoWindow> windows = maps.ReadPhoto(storage, *map, 0, world);
  REQUIRE(windows.size() == 1);
  CHECK(windows[0].grid.north_west_in_world == Eigen::Vector2d(0.0, 0.0));
  CHECK(windows[0].pixels(511, 511)[3] == 255);
}

}  // namespace
}  // namespace freelsd
