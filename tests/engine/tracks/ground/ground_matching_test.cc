#include <algorithm>
#include <cmath>
#include <map>

#include <doctest/doctest.h>

#include "engine/tracks/ground/ground_image.h"
#include "tests/engine/tracks/textured_plane.h"

namespace freelsd {
namespace {

constexpr double kHeightM = 100.0;

Camera SmallCamera() { return CenteredCamera(400, 300, 280.0); }

// Views whose poses are some metres off on the ground, with the truth beside them.
struct Strip {
  Rig rig;
  TexturedPlane plane{180.0};
  std::vector<View> views;
  std::vector<Rigid3d> truth;

  Strip() { rig.camera = SmallCamera(); }

  void Add(const Eigen::Vector3d& position,
           const EulerAngles& attitude,
           const Eigen::Vector3d& error_m = Eigen::Vector3d::Zero()) {
    truth.push_back(WorldFromCamera(rig, position, attitude));
    View view;
    view.frame_id = std::to_string(views.size());
    view.world_from_camera = truth.back();
    view.world_from_camera.translation += error_m;
    view.height_above_ground = kHeightM;
    views.push_back(view);
  }
  std::vector<View> Tied(const std::vector<int>& group) const {
    const ImageSource images = [this](const std::string& id) {
      return plane.Photograph(rig.camera, truth[static_cast<size_t>(std::stoi(id))]);
    };
    TracksOptions options;
    options.max_num_ground_keypoints = 800;
    return TieOnGround(views, group, rig.camera, images, options);
  }
};

// Where the sightings of each track lie on the true ground.
std::map<int64_t, std::vector<Eigen::Vector2d>> Places(const Strip& strip,
                                                       const std::vector<View>& views) {
  std::map<int64_t, std::vector<Eigen::Vector2d>> places;
  for (size_t i = 0; i < views.size(); ++i) {
    for (const Observation& seen : views[i].observations) {
      const Eigen::Vector3d from = strip.truth[i].translation;
      const Eigen::Vector3d ray =
          strip.truth[i].rotation * strip.rig.camera.RayFromImage(seen.point_in_image);
      places[seen.track_id].push_back((from - ray * (from.z() / ray.z())).head<2>());
    }
  }
  return places;
}

TEST_CASE("ground image: a tilted photograph looks as its ground does from above") {
  Strip strip;
  strip.Add({10.0, -5.0, kHeightM}, {.roll = 0.3, .pitch = -0.2, .yaw = 2.0});
  const GroundImage tilted = SeenFromAbove(strip.views[0],
                                           strip.rig.camera,
                                           strip.plane.Photograph(strip.rig.camera, strip.truth[0]),
                                           400);
  CHECK(tilted.pixel_m == doctest::Approx(kHeightM / 280.0));
  Strip level;
  level.Add({10.0, -5.0, kHeightM}, {.roll = 0.0, .pitch = 0.0, .yaw = 0.0});
  const cv::Mat above = level.plane.Photograph(level.rig.camera, level.truth[0]);
  double sum = 0.0;
  int count = 0;
  for (int row = 120; row < 180; ++row) {
    for (int col = 170; col < 230; ++col, ++count) {
      const Eigen::Vector2d place(10.0 + (col - 199.5) * kHeightM / 280.0,
                                  -5.0 - (row - 149.5) * kHeightM / 280.0);
      const Eigen::Vector2d pixel = tilted.PixelFromWorld(place);
      REQUIRE(cv::Rect(0, 0, tilted.grey.cols, tilted.grey.rows)
                  .contains(cv::Point(static_cast<int>(pixel.x()), static_cast<int>(pixel.y()))));
      const int there = tilted.grey.at<uchar>(static_cast<int>(std::lround(pixel.y())),
                                              static_cast<int>(std::lround(pixel.x())));
      sum += std::abs(there - above.at<uchar>(row, col));
    }
  }
  // Grey levels of 0..255 deviate by 40; half a pixel off costs a few.
  CHECK(sum / count < 8.0);
}

TEST_CASE("ground matching: groups that see one strip of ground are tied, to half a pixel") {
  Strip strip;
  strip.Add({-60.0, 0.0, kHeightM}, {.roll = 0.05, .pitch = 0.0, .yaw = 0.3});
  strip.Add({-20.0, 5.0, kHeightM}, {.roll = -0.1, .pitch = 0.1, .yaw = 0.2});
  strip.Add({60.0, 20.0, kHeightM}, {.roll = 0.05, .pitch = -0.15, .yaw = 3.6}, {4.0, -5.0, 2.0});
  const std::vector<View> tied = strip.Tied({0, 0, 1});
  const auto places = Places(strip, tied);
  std::vector<double> errors_px;
  int num_across = 0;
  for (const auto& [id, seen] : places) {
    for (size_t i = 1; i < seen.size(); ++i) {
      errors_px.push_back((seen[i] - seen[0]).norm() / kHeightM * 280.0);
    }
  }
  for (const Observation& seen : tied[2].observations) {
    num_across += places.at(seen.track_id).size() >= 2 ? 1 : 0;
  }
  CHECK(num_across >= 12);
  REQUIRE_FALSE(errors_px.empty());
  std::sort(errors_px.begin(), errors_px.end());
  CHECK(errors_px[errors_px.size() / 2] < 0.5);
  CHECK(errors_px[errors_px.size() * 95 / 100] < 3.0);
}

TEST_CASE("ground matching: views of one group, and of ground far apart, are left as they are") {
  Strip strip;
  strip.Add({-60.0, 0.0, kHeightM}, {.roll = 0.0, .pitch = 0.0, .yaw = 0.3});
  strip.Add({-20.0, 0.0, kHeightM}, {.roll = 0.0, .pitch = 0.0, .yaw = 0.3});
  strip.views[0].observations.push_back({5, {1.0, 2.0}});
  CHECK(strip.Tied({0, 0})[0].observations.size() == 1);
  CHECK(strip.Tied({0, 0})[1].observations.empty());
  const std::vector<View> tied = strip.Tied({0, -1});
  REQUIRE(tied[0].observations.size() > 1);
  CHECK(tied[0].observations[0].track_id == 5);
  CHECK(tied[0].observations[1].track_id > 5);
  strip.views[1].world_from_camera.translation.x() += 400.0;
  CHECK(strip.Tied({0, 1})[1].observations.empty());
}

TEST_CASE("ground matching: an image that is gone and a view of the sky tie nothing") {
  Strip strip;
  strip.Add({0.0, 0.0, kHeightM}, {.roll = 0.0, .pitch = 0.0, .yaw = 0.0});
  strip.Add({10.0, 0.0, kHeightM}, {.roll = 3.0, .pitch = 0.0, .yaw = 0.0});
  CHECK(strip.Tied({0, 1})[0].observations.empty());
  strip.views[1].world_from_camera.rotation = strip.views[0].world_from_camera.rotation;
  const ImageSource gone = [](const std::string&) { return cv::Mat(); };
  CHECK(TieOnGround(strip.views, {0, 1}, strip.rig.camera, gone, {})[0].observations.empty());
}

}  // namespace
}  // namespace freelsd
