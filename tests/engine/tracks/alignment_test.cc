#include <algorithm>
#include <random>

#include <doctest/doctest.h>

#include "tests/engine/tracks/textured_plane.h"

namespace freelsd {
namespace {

constexpr double kHeightM = 120.0;
constexpr double kNoisePx = 0.8;

// Photographs of different place, heading and tilt, and the same ground points in each of them,
// seen with noise.
struct NoisyViews {
  Rig rig;
  std::vector<View> views;
  std::vector<cv::Mat> images;
  std::vector<std::vector<Eigen::Vector2d>> truth;

  NoisyViews() {
    rig.camera = CenteredCamera(1200, 900, 600.0);
    const TexturedPlane plane(250.0);
    std::mt19937 random(3);
    std::normal_distribution<double> noise(0.0, kNoisePx);
    for (int i = 0; i < 4; ++i) {
      View view;
      view.frame_id = std::to_string(i);
      view.world_from_camera = WorldFromCamera(rig,
                                               {12.0 * i - 18.0, 7.0 * i - 10.0, kHeightM},
                                               {.roll = 0.02 * i, .pitch = 0.06, .yaw = i * 1.1});
      view.height_above_ground = kHeightM;
      images.push_back(plane.Photograph(rig.camera, view.world_from_camera));
      truth.emplace_back();
      for (int point = 0; point < 120; ++point) {
        const int row = point / 12, col = point % 12;
        const Eigen::Vector3d place(9.0 * col - 50.0, 9.0 * row - 40.0, 0.0);
        const auto pixel = rig.camera.ImageFromCamera(Inverse(view.world_from_camera) * place);
        truth.back().push_back(*pixel);
        view.observations.push_back(
            {point, *pixel + Eigen::Vector2d{noise(random), noise(random)}});
      }
      views.push_back(view);
    }
  }

  // Errors of the sightings of a view relative to those of the first view, px, ascending. The place
  // that a track shows is free, so only the difference counts.
  std::vector<double> RelativeErrorsPx(const std::vector<View>& seen, size_t view) const {
    std::vector<double> errors;
    for (size_t i = 0; i < truth[view].size(); ++i) {
      const Camera& camera = rig.camera;
      const Eigen::Vector3d ray = seen[0].world_from_camera.rotation *
                                  camera.RayFromImage(seen[0].observations[i].point_in_image);
      const Eigen::Vector3d place =
          seen[0].world_from_camera.translation + ray * (kHeightM / -ray.z());
      const auto expected = camera.ImageFromCamera(Inverse(seen[view].world_from_camera) * place);
      errors.push_back((*expected - seen[view].observations[i].point_in_image).norm());
    }
    std::sort(errors.begin(), errors.end());
    return errors;
  }
};

TEST_CASE("alignment: all noisy sightings but one agree to a fifth of a pixel afterwards") {
  constexpr double kMaxErrorPx = 0.2;
  // A patch may be like another one some pixels away. The adjustment drops such a sighting.
  constexpr size_t kNumWrong = 1;
  const NoisyViews noisy;
  const ImageSource images = [&](const std::string& id) { return noisy.images[std::stoul(id)]; };
  const std::vector<View> aligned = AlignSightings(noisy.views, noisy.rig.camera, images, {});
  for (size_t view = 1; view < noisy.views.size(); ++view) {
    CAPTURE(view);
    const std::vector<double> before = noisy.RelativeErrorsPx(noisy.views, view);
    const std::vector<double> after = noisy.RelativeErrorsPx(aligned, view);
    CHECK(before[before.size() / 2] > kNoisePx);
    CHECK(after[after.size() - 1 - kNumWrong] < kMaxErrorPx);
  }
}

TEST_CASE("alignment: sightings stay where images are missing, flat or not reduced for matching") {
  const NoisyViews noisy;
  const auto is_same = [&](const ImageSource& images, const TracksOptions& options) {
    const auto after = AlignSightings(noisy.views, noisy.rig.camera, images, options);
    bool is_equal = true;
    for (size_t view = 0; view < after.size(); ++view) {
      for (size_t i = 0; i < after[view].observations.size(); ++i) {
        is_equal = is_equal && after[view].observations[i].point_in_image ==
                                   noisy.views[view].observations[i].point_in_image;
      }
    }
    return is_equal;
  };
  const ImageSource images = [&](const std::string& id) { return noisy.images[std::stoul(id)]; };
  TracksOptions full, none;
  full.matching_width_px = noisy.rig.camera.width_px;
  none.max_alignment_shift_px = 0.0;
  CHECK(is_same(images, full));
  CHECK(is_same(images, none));
  CHECK(is_same([](const std::string&) { return cv::Mat(); }, {}));
  CHECK(is_same([](const std::string&) { return cv::Mat(900, 1200, CV_8U, cv::Scalar(99)); }, {}));
  CHECK_FALSE(is_same(images, {}));
}

}  // namespace
}  // namespace freelsd
