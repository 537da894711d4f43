#include <doctest/doctest.h>

#include "tests/engine/adjustment/survey.h"

namespace freelsd {
namespace {

// A view `east` metres along whose tracks are [first, first + count).
View VideoView(double east, int64_t first, int count) {
  View view;
  view.world_from_camera = {NadirCamera(kPi / 2), {east, 0.0, 100.0}};
  view.prior_world_from_camera = view.world_from_camera.rotation;
  view.height_above_ground = 100.0;
  for (int i = 0; i < count; ++i) view.observations.push_back({first + i, {0.0, 0.0}});
  return view;
}

TEST_CASE("key-frames: the predecessor of the first view with fewer than 30 connections is next") {
  // 100 tracks per view, 10 lost from one view to the next, 2.5 m apart: view 8 has 20 left of view
  // 0's, so view 7 is due.
  std::vector<View> views;
  views.reserve(20);
  for (int i = 0; i < 20; ++i) views.push_back(VideoView(2.5 * i, int64_t{10} * i, 100));
  CHECK(SelectKeyframes(views, {}) == std::vector<size_t>{0, 7, 14, 19});
}

TEST_CASE("key-frames: a baseline too short for stereo makes none, a long one does at the latest") {
  std::vector<View> hover(10, VideoView(0.0, 0, 5));
  for (size_t i = 0; i < hover.size(); ++i) hover[i].observations[0].track_id = 100 + i;
  CHECK(SelectKeyframes(hover, {}) == std::vector<size_t>{0});
  std::vector<View> survey;
  survey.reserve(4);
  for (int i = 0; i < 4; ++i) survey.push_back(VideoView(40.0 * i, 0, 200));
  CHECK(SelectKeyframes(survey, {}) == std::vector<size_t>{0, 1, 2, 3});
  CHECK(SelectKeyframes({}, {}).empty());
}

}  // namespace
}  // namespace freelsd
