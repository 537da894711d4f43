#include <algorithm>
#include <cstring>
#include <random>
#include <stdexcept>

#include <doctest/doctest.h>

#include "api/stored/stored.h"
#include "tests/api/export/layers/hill_map.h"

namespace freelsd {
namespace {

template <typename T>
bool SameBytes(const cv::Mat_<T>& a, const cv::Mat_<T>& b) {
  return a.size() == b.size() && std::equal(a.datastart, a.dataend, b.datastart);
}

bool SameMaps(const SiteMap& a, const SiteMap& b) {
  return a.map.grid == b.map.grid && a.layers.grid == b.layers.grid &&
         SameBytes(a.map.elevation, b.map.elevation) && SameBytes(a.map.upper, b.map.upper) &&
         SameBytes(a.map.standard_deviation, b.map.standard_deviation) &&
         SameBytes(a.map.num_points, b.map.num_points) &&
         SameBytes(a.layers.slope, b.layers.slope) &&
         SameBytes(a.layers.roughness, b.layers.roughness) &&
         SameBytes(a.layers.grass, b.layers.grass) && SameBytes(a.layers.hazard, b.layers.hazard) &&
         SameBytes(a.layers.distance, b.layers.distance);
}

TEST_CASE("site map: what was stored comes back to the bit, unseen cells too") {
  const SiteMap site_map = HillMap();
  const std::string bytes = SerializeSiteMap(site_map);
  CHECK(bytes.size() < 60 * 80 * 33 / 2);
  CHECK(SameMaps(DeserializeSiteMap(bytes), site_map));
  CHECK(SerializeSiteMap(DeserializeSiteMap(bytes)) == bytes);
}

TEST_CASE("site map: whether photographs were compared is kept") {
  for (const bool is_compared : {false, true}) {
    SiteMap site_map;
    site_map.map.is_compared = is_compared;
    CHECK(DeserializeSiteMap(SerializeSiteMap(site_map)).map.is_compared == is_compared);
  }
}

TEST_CASE("site map: an empty map survives, too") {
  const SiteMap back = DeserializeSiteMap(SerializeSiteMap(SiteMap{}));
  CHECK(back.map.elevation.empty());
  CHECK(back.map.grid.num_rows == 0);
}

TEST_CASE("site map: whatever is cut off is refused") {
  const std::string bytes = SerializeSiteMap(HillMap());
  for (size_t length = 0; length < bytes.size(); length += length < 64 ? 1 : 97) {
    CHECK_THROWS_AS(DeserializeSiteMap(bytes.substr(0, length)), std::runtime_error);
  }
  CHECK_THROWS_AS(DeserializeSiteMap("not a map at all, and longer than a header"),
                  std::runtime_error);
}

TEST_CASE("site map: a damaged bit is refused or changes nothing") {
  const SiteMap site_map = HillMap();
  const std::string bytes = SerializeSiteMap(site_map);
  std::mt19937 random(1);
  int num_refused = 0;
  for (int i = 0; i < 400; ++i) {
    std::string damaged = bytes;
    const size_t position = i < 24 ? i : random() % bytes.size();
    damaged[position] = static_cast<char>(damaged[position] ^ (1 << random() % 8));
    SiteMap back;
    try {
      back = DeserializeSiteMap(damaged);
    } catch (const std::runtime_error&) {
      ++num_refused;
      continue;
    }
    CHECK(SameMaps(back, site_map));
  }
  CHECK(num_refused > 390);
}

TEST_CASE("site map: a claimed size beyond what the bytes can hold is refused before allocation") {
  std::string bytes = SerializeSiteMap(SiteMap{});
  for (const uint64_t size : {uint64_t{800000000}, uint64_t{1} << 62, ~uint64_t{0}, uint64_t{0}}) {
    std::memcpy(bytes.data() + 8, &size, sizeof(size));
    CHECK_THROWS_AS(DeserializeSiteMap(bytes), std::runtime_error);
  }
}

}  // namespace
}  // namespace freelsd
