#include "engine/tracks/track_table.h"

#include <doctest/doctest.h>

namespace freelsd {
namespace {

TrackTable::Place PlaceOf(size_t frame, int point) {
  return {frame, point, Eigen::Vector2d(10.0 * static_cast<double>(frame), point)};
}

TrackTable TableOf(int num_frames) {
  TrackTable table;
  for (int i = 0; i < num_frames; ++i) table.AddFrame();
  return table;
}

TEST_CASE("track table: matches of three frames join into one track") {
  TrackTable table = TableOf(3);
  table.Join(PlaceOf(0, 5), PlaceOf(1, 7));
  table.Join(PlaceOf(2, 9), PlaceOf(1, 7));
  REQUIRE(table.ObservationsOf(2).size() == 1);
  CHECK(table.ObservationsOf(0)[0].track_id == table.ObservationsOf(2)[0].track_id);
  CHECK(table.MembersOf(table.ObservationsOf(0)[0].track_id).size() == 3);
}

TEST_CASE("track table: two tracks that prove to be one place get one id everywhere") {
  TrackTable table = TableOf(4);
  table.Join(PlaceOf(0, 1), PlaceOf(1, 1));
  table.Join(PlaceOf(2, 1), PlaceOf(3, 1));
  table.TakeChangedFrames();
  table.Join(PlaceOf(3, 1), PlaceOf(0, 1));
  const int64_t track_id = table.ObservationsOf(0)[0].track_id;
  for (size_t frame = 0; frame < 4; ++frame) {
    REQUIRE(table.ObservationsOf(frame).size() == 1);
    CHECK(table.ObservationsOf(frame)[0].track_id == track_id);
    CHECK(table.ObservationsOf(frame)[0].point_in_image.x() ==
          doctest::Approx(10.0 * static_cast<double>(frame)));
  }
  CHECK(table.MembersOf(track_id).size() == 4);
  CHECK(!table.TakeChangedFrames().empty());
}

TEST_CASE("track table: a match that would show one place twice in a frame is dropped") {
  TrackTable table = TableOf(3);
  table.Join(PlaceOf(0, 1), PlaceOf(1, 1));
  table.Join(PlaceOf(1, 1), PlaceOf(2, 1));
  SUBCASE("a new point") {
    table.Join(PlaceOf(0, 2), PlaceOf(2, 1));
    CHECK(table.ObservationsOf(0).size() == 1);
  }
  SUBCASE("a point on another track") {
    table.Join(PlaceOf(0, 2), PlaceOf(1, 2));
    table.Join(PlaceOf(1, 2), PlaceOf(2, 1));
    CHECK(table.ObservationsOf(0)[0].track_id != table.ObservationsOf(0)[1].track_id);
    CHECK(table.ObservationsOf(2).size() == 1);
  }
}

}  // namespace
}  // namespace freelsd
