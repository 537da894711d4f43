#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "tests/api/errors.h"
#include "tests/api/plans.h"

namespace freelsd {
namespace {

TEST_CASE("region: closed ring, counter-clockwise, and null for no wind") {
  const nlohmann::json feature = RegionFeature(LandableSite().region, std::nullopt, Context());
  const nlohmann::json ring = feature["geometry"]["coordinates"][0];
  REQUIRE(ring.size() == 5);
  CHECK(ring[0] == ring[4]);
  Polygon polygon;
  for (size_t i = 0; i < 4; ++i) polygon.emplace_back(ring[i][0], ring[i][1]);
  CHECK(SignedArea(polygon) > 0.0);
  CHECK(feature["properties"]["wind"].is_null());
  CHECK(feature["properties"]["id"] == 4);
}

TEST_CASE("region: history as in the paper's plots") {
  const nlohmann::json history = RegionHistoryJson(LandableSite().region)["history"];
  REQUIRE(history.size() == 2);
  CHECK(history[1]["grass_ratio"] == 0.5);
  CHECK(history[1]["frame_id"] == "b");
}

}  // namespace
}  // namespace freelsd
