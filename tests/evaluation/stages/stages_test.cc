// Records keep every bit, and a comparison names what differs and by how much.
#include <cmath>
#include <filesystem>
#include <limits>

#include <doctest/doctest.h>

#include "tests/evaluation/stages/block_record.h"

namespace freelsd {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

TEST_CASE("stages: records are read back bit by bit") {
  const std::string path = std::filesystem::temp_directory_path() / "freelsd_stages_test";
  const StageRecords records{{"tracks", "px", {0.1, kUnknown, std::nextafter(1.0, 2.0)}},
                             {"hazard", "m", {}}};
  WriteRecords(path, records);
  const auto differences = Compare(records, ReadRecords(path));
  std::filesystem::remove(path);
  REQUIRE(differences.size() == 2);
  CHECK(differences[0].IsEqual());
  CHECK(differences[0].num_values_b == 3);
  CHECK(differences[1].IsEqual());
}

TEST_CASE("stages: one bit is a difference, and so is ground that only one knows") {
  const StageRecords a{{"terrain", "m", {1.0, 2.0, kUnknown, 4.0}}};
  const StageRecords b{{"terrain", "m", {std::nextafter(1.0, 2.0), 2.5, 3.0, 4.0}}};
  const StageDifference difference = Compare(a, b).at(0);
  CHECK(!difference.IsEqual());
  CHECK(difference.num_unequal == 3);
  CHECK(difference.num_known_in_one == 1);
  CHECK(difference.largest == 0.5);
}

TEST_CASE("stages: other counts are a difference, other stages an error") {
  const StageRecords a{{"terrain", "m", {1.0}}};
  CHECK(!Compare(a, {{"terrain", "m", {1.0, 2.0}}}).at(0).IsEqual());
  CHECK_THROWS_AS(Compare(a, {{"hazard", "m", {1.0}}}), std::invalid_argument);
  CHECK_THROWS_AS(Compare(a, {}), std::invalid_argument);
}

TEST_CASE("stages: a map and a block come back from their records") {
  ElevationMap map;
  map.grid = {{3.5, -2.0}, 0.5, 2, 3};
  map.elevation = (cv::Mat1f(2, 3) << 1.0f, 0.1f, 2.0f, 3.0f, 4.0f, std::nanf(""));
  map.upper = map.standard_deviation = map.num_points = map.elevation;
  map.position_sd_m = 0.7;
  map.is_compared = true;
  const ElevationMap read = MapFrom(RecordsOf(map));
  CHECK(read.grid == map.grid);
  CHECK(read.is_compared);
  for (const StageDifference& each : Compare(RecordsOf(map), RecordsOf(read)))
    CHECK(each.IsEqual());

  CHECK(MapFrom(RecordsOf(ElevationMap{})).grid.num_rows == 0);

  const std::vector<std::string> ids{"a", "not a key-frame", "b"};
  AdjustedBlock block;
  block.views.resize(2);
  block.views[0].frame_id = "a";
  block.views[1].frame_id = "b";
  block.views[1].is_connected = true;
  block.views[1].landmarks = {0};
  block.views[1].world_from_camera.translation = {1.0, 2.0, 80.1};
  block.landmarks = {{{0.1, 0.2, 0.3}, 0.5, 2}};
  const AdjustedBlock again = BlockFrom(RecordsOf(block, ids), Camera{}, ids);
  CHECK(again.views[1].frame_id == "b");
  for (const StageDifference& each : Compare(RecordsOf(block, ids), RecordsOf(again, ids)))
    CHECK(each.IsEqual());
}

}  // namespace
}  // namespace freelsd
