#include <cmath>
#include <map>
#include <string>

#include <doctest/doctest.h>
#include <opencv2/core/utility.hpp>

#include "tests/engine/tracks/textured_plane.h"

namespace freelsd {
namespace {

constexpr double kHeightM = 100.0;

// Two strips of three views over a textured plane, headed against each other. Each point belongs to
// a track of its strip alone. The second strip's poses are off by a metre.
struct TwoStrips {
  Rig rig = VideoRig();
  TexturedPlane plane{260.0};
  std::vector<View> views;
  std::vector<Rigid3d> truth;
  TrackPoints points;

  TwoStrips() {
    for (const bool is_back : {false, true}) {
      for (int i = 0; i < 3; ++i) {
        const double north = (is_back ? 1.0 - i : i - 1.0) * 30.0;
        Add({is_back ? 60.0 : 0.0, north, kHeightM}, is_back);
      }
    }
  }

  void Add(const Eigen::Vector3d& position, bool is_back) {
    truth.push_back(WorldFromCamera(rig, position, {.yaw = is_back ? kPi : 0.0}));
    View view;
    view.frame_id = std::to_string(views.size());
    view.world_from_camera = truth.back();
    if (is_back) view.world_from_camera.translation += Eigen::Vector3d(0.8, -0.6, 0.5);
    view.height_above_ground = kHeightM;
    // A lattice of ground points; ids of the strips differ.
    const Rigid3d camera_from_world = Inverse(truth.back());
    for (int east = -100; east <= 160; east += 6) {
      for (int north = -120; north <= 120; north += 6) {
        const Eigen::Vector3d point(east, north, 0.0);
        const auto pixel = rig.camera.ImageFromCamera(camera_from_world * point);
        if (!pixel || !rig.camera.IsInside(*pixel, 20.0)) continue;
        const int64_t id = (is_back ? 1'000'000 : 0) + 1000 * (east + 200) + north + 200;
        points[id] = point;
        view.observations.push_back({id, *pixel});
      }
    }
    views.push_back(view);
  }

  std::vector<View> Followed(const TracksOptions& options = {}) const {
    const ImageSource images = [this](const std::string& id) {
      return plane.Photograph(rig.camera, truth[static_cast<size_t>(std::stoi(id))]);
    };
    return FollowIntoOverlaps(views, points, rig.camera, images, options);
  }
};

TEST_CASE(
    "overlaps: points of one strip are found in the other, both ways, to a third of a pixel") {
  const TwoStrips strips;
  const std::vector<View> followed = strips.Followed();
  for (size_t i = 0; i < followed.size(); ++i) {
    const std::vector<Observation>& seen = followed[i].observations;
    const size_t num_before = strips.views[i].observations.size();
    REQUIRE(seen.size() >= num_before + 30);
    const Rigid3d camera_from_world = Inverse(strips.truth[i]);
    double sum = 0.0;
    std::map<int64_t, int> num_of_track;
    for (size_t k = num_before; k < seen.size(); ++k) {
      CHECK((seen[k].track_id >= 1'000'000) == (i < 3));
      CHECK(++num_of_track[seen[k].track_id] == 1);
      const Eigen::Vector3d& point = strips.points.at(seen[k].track_id);
      const auto shown = strips.rig.camera.ImageFromCamera(camera_from_world * point);
      REQUIRE(shown.has_value());
      sum += (*shown - seen[k].point_in_image).squaredNorm();
    }
    CHECK(std::sqrt(sum / static_cast<double>(seen.size() - num_before)) < 0.33);
  }
}

TEST_CASE("overlaps: the number of threads changes nothing") {
  const TwoStrips strips;
  const int num_threads = cv::getNumThreads();
  cv::setNumThreads(1);
  const std::vector<View> alone = strips.Followed();
  cv::setNumThreads(3);
  const std::vector<View> together = strips.Followed();
  cv::setNumThreads(num_threads);
  for (size_t i = 0; i < alone.size(); ++i) {
    REQUIRE(alone[i].observations.size() == together[i].observations.size());
    for (size_t k = 0; k < alone[i].observations.size(); ++k) {
      CHECK(alone[i].observations[k].track_id == together[i].observations[k].track_id);
      CHECK(alone[i].observations[k].point_in_image == together[i].observations[k].point_in_image);
    }
  }
}

TEST_CASE("overlaps: views that share enough points, and without an image, are left alone") {
  const TwoStrips strips;
  TracksOptions none_are_loose;
  none_are_loose.max_num_shared_points = 0;
  const std::vector<View> tied = strips.Followed(none_are_loose);
  const ImageSource gone = [](const std::string&) { return cv::Mat(); };
  const std::vector<View> blind =
      FollowIntoOverlaps(strips.views, strips.points, strips.rig.camera, gone, {});
  for (size_t i = 0; i < tied.size(); ++i) {
    CHECK(tied[i].observations.size() == strips.views[i].observations.size());
    CHECK(blind[i].observations.size() == strips.views[i].observations.size());
  }
}

}  // namespace
}  // namespace freelsd
