#include "server/recall/map_cache.h"

#include <cmath>

#include <doctest/doctest.h>

#include "tests/server/meadow.h"
#include "tests/server/site_on_map.h"

namespace freelsd {
namespace {

constexpr BoundingBox kEverywhere{-180.0, -90.0, 180.0, 90.0};

std::shared_ptr<const RecallRow> OnlyRow(const Storage& storage) {
  const auto rows = storage.sites.ListRecallable(kEverywhere);
  REQUIRE(rows.size() == 1);
  return rows.front();
}

TEST_CASE("map cache: a plan stays when its map is dropped, but not for another wind or update") {
  const TemporaryFolder folder;
  Storage storage(StorageAt(folder.path()));
  PutOnMap(storage, MeadowSite("amsl"), Meadow());
  SiteRow other = MeadowSite("amsl", 5000.0);
  other.id = std::string("f-r2");
  other.recall.reset();
  PutOnMap(storage, other, Meadow());
  // Room for one map.
  MapCache maps({1, 1});
  const auto row = OnlyRow(storage);
  const Aircraft aircraft = Unpowered(*AircraftProfile("small"), std::nullopt);
  const Eigen::Vector2d wind(1.0, 2.0);
  const auto plan = maps.PlanOf(storage, *row, aircraft, "small", wind);
  REQUIRE(plan);
  const auto map = maps.Get(storage, row->site_id, row->updated_at_us);
  REQUIRE(maps.Get(storage, other.id, other.updated_at_us));
  CHECK(maps.Get(storage, row->site_id, row->updated_at_us) != map);
  CHECK(maps.PlanOf(storage, *row, aircraft, "small", wind)->plan == plan->plan);
  const Eigen::Vector2d other_wind(1.0, 2.0000001);
  CHECK(maps.PlanOf(storage, *row, aircraft, "small", other_wind)->plan != plan->plan);
  CHECK(maps.PlanOf(storage, *row, aircraft, "other", wind)->plan != plan->plan);
  RecallRow updated = *row;
  ++updated.updated_at_us;
  CHECK(maps.PlanOf(storage, updated, aircraft, "small", wind)->plan != plan->plan);
  const auto again = maps.PlanOf(storage, updated, aircraft, "small", wind);
  maps.DropPlans(row->site_id);
  CHECK(maps.PlanOf(storage, updated, aircraft, "small", wind)->plan != again->plan);
}

TEST_CASE(
    "map cache: terrain in blocks is never lower than the map, nor seen where the map is not") {
  const TemporaryFolder folder;
  Storage storage(StorageAt(folder.path()));
  SiteMap bumpy = Meadow();
  for (int row = 0; row < 600; ++row) {
    for (int col = 0; col < 600; ++col) {
      bumpy.map.upper(row, col) = static_cast<float>((row * 7 + col * 13) % 23);
      if ((row * 31 + col * 17) % 101 != 0) continue;
      bumpy.map.upper(row, col) = bumpy.map.num_points(row, col) = std::nanf("");
    }
  }
  PutOnMap(storage, MeadowSite("amsl"), bumpy);
  MapCache maps({1, 1});
  const auto row = OnlyRow(storage);
  const auto terrain = maps.TerrainOf(storage, row->map_id);
  REQUIRE(terrain);
  CHECK(terrain->grid.num_rows < 600);
  bool is_ever_lower = false, is_ever_seen = false;
  for (int y = 0; y < 600; ++y) {
    for (int x = 0; x < 600; ++x) {
      const auto block = terrain->grid.CellAt(bumpy.map.grid.CellCenter(y, x));
      REQUIRE(block);
      const float height = bumpy.map.upper(y, x);
      is_ever_lower |= terrain->upper(*block) < height;
      is_ever_seen |= std::isnan(height) && terrain->is_seen(*block) != 0;
    }
  }
  CHECK_FALSE(is_ever_lower);
  CHECK_FALSE(is_ever_seen);
  CHECK(cv::countNonZero(terrain->is_seen) > 0);
}

}  // namespace
}  // namespace freelsd
