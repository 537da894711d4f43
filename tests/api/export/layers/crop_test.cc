#include <doctest/doctest.h>

#include "api/export/layers/layers.h"
#include "tests/api/export/layers/hill_map.h"

namespace freelsd {
namespace {

TEST_CASE("crop: it holds the footprint and the seen cells near it, in place") {
  const SiteMap whole = HillMap();
  const Polygon footprint{{0, 0}, {10, 0}, {10, 10}, {0, 10}};
  const SiteMap part = CropAround(whole.map, whole.layers, footprint, 5.0);
  CHECK(part.map.grid.north_west_in_world == Eigen::Vector2d(-5.0, 15.0));
  CHECK(part.map.grid.num_rows == 20);
  CHECK(part.map.grid.num_cols == 20);
  CHECK(part.layers.grid == part.map.grid);
  const cv::Point there = *part.map.grid.CellAt({3.5, 4.5});
  const cv::Point here = *whole.map.grid.CellAt({3.5, 4.5});
  CHECK(part.map.elevation(there) == whole.map.elevation(here));
  CHECK(part.layers.distance(there) == whole.layers.distance(here));
}

TEST_CASE("crop: it ends where nothing was seen, and at the map's border") {
  const SiteMap whole = HillMap();
  // A field in the unseen corner: the box is the field's and the seen cells within the margin.
  const SiteMap corner =
      CropAround(whole.map, whole.layers, {{-29, -19}, {-26, -19}, {-26, -16}, {-29, -16}}, 2.0);
  CHECK(corner.map.grid.num_rows == 3);
  CHECK(corner.map.grid.num_cols == 3);
  const Polygon all{{-500, -500}, {500, -500}, {500, 500}, {-500, 500}};
  CHECK(CropAround(whole.map, whole.layers, all, 1e9).map.grid == whole.map.grid);
  CHECK(CropAround(whole.map, whole.layers, {{900, 900}, {910, 900}, {910, 910}}, 5.0)
            .map.elevation.empty());
  CHECK(CropAround(whole.map, whole.layers, {}, 5.0).map.elevation.empty());
  CHECK(CropAround({}, {}, all, 5.0).map.elevation.empty());
}

}  // namespace
}  // namespace freelsd
