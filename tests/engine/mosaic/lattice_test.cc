// Pixels and tiles are the same places for every flight.
#include <doctest/doctest.h>

#include "engine/mosaic/mosaic.h"
#include "tests/engine/cover/views_from_above.h"
#include "tests/engine/refusal.h"

namespace freelsd {
namespace {

using above::BlockOf;
using above::kHeightM;
using above::LevelMap;
using above::TwoNadirViews;

ElevationMap MapAt(double west, double north, int num_cells, double cell_size_m) {
  ElevationMap map = LevelMap(num_cells, cell_size_m);
  map.grid.north_west_in_world = {west, north};
  return map;
}

TEST_CASE("mosaic lattice: a cell is a whole number of pixels, near the ground sampling") {
  AdjustedBlock block = BlockOf(TwoNadirViews());
  for (double focal_px = 100.0; focal_px < 4000.0; focal_px *= 1.07) {
    block.camera.fx_px = block.camera.fy_px = focal_px;
    for (const double cell_size_m : {0.3, 0.5, 1.0, 2.0}) {
      const MosaicLattice lattice = PlanMosaic(LevelMap(40, cell_size_m), block, {});
      const double count = cell_size_m / lattice.pixel_size_m;
      CHECK(count == doctest::Approx(std::round(count)).epsilon(1e-9));
      const double sampling_m = std::max(kHeightM / focal_px, 0.02);
      CHECK(lattice.pixel_size_m >= std::min(cell_size_m, 0.969 * sampling_m));
      if (count > 1.5) CHECK(lattice.pixel_size_m < sampling_m * (1.0 + 1.1 / count));
    }
  }
}

TEST_CASE("mosaic lattice: tiles cover the map, and are those of the world and not of the map") {
  const AdjustedBlock block = BlockOf(TwoNadirViews());
  MosaicOptions options;
  options.tile_size_px = 64;
  // A tile is 64 / 6 m.
  const MosaicLattice lattice = PlanMosaic(MapAt(-25.0, 12.0, 40, 1.0), block, options);
  CHECK(lattice.TileSideM(0) == doctest::Approx(64.0 / 6.0));
  CHECK(lattice.tiles == cv::Rect(-3, -2, 5, 5));
  CHECK(lattice.TilesOf(1) == cv::Rect(-2, -1, 3, 3));
  // 40 m are four tiles at least, so three levels make them one tile long.
  CHECK(lattice.num_levels == 3);
  CHECK(lattice.TileSideM(2) >= 40.0);
  const MosaicLattice moved = PlanMosaic(MapAt(-24.0, 12.0, 40, 1.0), block, options);
  CHECK(moved.pixel_size_m == lattice.pixel_size_m);
  CHECK(moved.tiles.tl() == lattice.tiles.tl());
}

TEST_CASE("mosaic lattice: a map beside the world's lattice is refused") {
  const AdjustedBlock block = BlockOf(TwoNadirViews());
  CHECK_THROWS_AS(PlanMosaic(MapAt(0.5, 0.0, 10, 1.0), block, {}), std::invalid_argument);
  CHECK_THROWS_AS(PlanMosaic(MapAt(0.0, 0.3, 10, 1.0), block, {}), std::invalid_argument);
}

TEST_CASE("mosaic options: values outside their bounds are refused by name") {
  CHECK(RefusalOf(&MosaicOptions::tile_size_px, 100) ==
        "mosaic.tile_size_px = 100: must be a power of two");
  CHECK(IsRefused(&MosaicOptions::min_pixel_size_m, 0.0, "min_pixel_size_m"));
  CHECK(IsRefused(&MosaicOptions::max_num_candidates, 0, "max_num_candidates"));
  CHECK(IsRefused(&MosaicOptions::gain_sd, std::nan(""), "gain_sd"));
}

}  // namespace
}  // namespace freelsd
