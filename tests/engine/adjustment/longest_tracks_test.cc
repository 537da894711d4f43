#include <doctest/doctest.h>

#include "tests/engine/adjustment/survey.h"

namespace freelsd {
namespace {

size_t NumObservations(const std::vector<View>& views) {
  size_t sum = 0;
  for (const View& view : views) sum += view.observations.size();
  return sum;
}

TEST_CASE("longest tracks: of each part of an image the longest stay, in all of their views") {
  // Ten tracks in one corner of three views, of which three are seen thrice; one in another.
  std::vector<View> views(3);
  for (int64_t id = 0; id < 10; ++id) {
    for (size_t view = 0; view < (id >= 7 ? 3 : 2); ++view) {
      views[view].observations.push_back({id, {10.0 + static_cast<double>(id), 10.0}});
    }
  }
  views[0].observations.push_back({20, {990.0, 740.0}});
  views[1].observations.push_back({20, {980.0, 740.0}});
  const std::vector<View> kept = WithLongestTracks(views, SurveyCamera(), 50);  // 2 for each of 25
  REQUIRE(kept.size() == 3);
  REQUIRE(kept[0].observations.size() == 3);
  CHECK(kept[0].observations[0].track_id == 7);
  CHECK(kept[0].observations[1].track_id == 8);
  CHECK(kept[0].observations[2].track_id == 20);
  CHECK(kept[1].observations.size() == 3);
  CHECK(kept[2].observations.size() == 2);
}

TEST_CASE("longest tracks: what one view alone sees ties nothing, 0 keeps all") {
  std::vector<View> views(2);
  views[0].observations = {{1, {10.0, 10.0}}, {2, {400.0, 200.0}}};
  views[1].observations = {{1, {20.0, 10.0}}};
  CHECK(NumObservations(WithLongestTracks(views, SurveyCamera(), 100)) == 2);
  CHECK(NumObservations(WithLongestTracks(views, SurveyCamera(), 0)) == 3);
  CHECK(WithLongestTracks({}, SurveyCamera(), 100).empty());
}

}  // namespace
}  // namespace freelsd
