#include <algorithm>
#include <stdexcept>

#include <Eigen/Dense>
#include <doctest/doctest.h>

#include "tests/engine/refusal.h"
#include "tests/engine/stereo/scene.h"

namespace freelsd {
namespace {

// At 80 m and 0.2 m ground sampling.
constexpr double kMaxHeightRmseM = 0.25;
constexpr double kMaxSlopeErrorDeg = 0.5;
constexpr double kMaxOutlierM = 1.0;
constexpr size_t kMinNumPoints = 50000;

double Flat(double, double) { return 0.0; }
// Falls 5 deg to the west.
double Tilted(double east, double) { return 0.0875 * east; }
double HillInTheEast(double east, double north) {
  return 8.0 * std::exp(-((east - 12.0) * (east - 12.0) + north * north) / 80.0);
}

Scene SceneOf(const HeightField& height) { return {SceneCamera(), height, GroundTexture()}; }

Points Reconstruct(const Scene& scene, const Rigid3d& left, const Rigid3d& right) {
  return ReconstructPoints(SceneBlock(scene, {left, right}),
                           {0, 1, 0.0},
                           Render(scene, left, 1),
                           Render(scene, right, 2),
                           {});
}

struct HeightErrors {
  double rmse_m = 0.0;
  double mean_sd_m = 0.0;
  double outlier_ratio = 0.0;
};

HeightErrors Compare(const Scene& scene, const Points& points) {
  HeightErrors errors;
  for (const DensePoint& point : points) {
    const Eigen::Vector3d p = point.point_in_world.cast<double>();
    const double error = p.z() - scene.height(p.x(), p.y());
    errors.rmse_m += error * error;
    errors.mean_sd_m += point.height_sd_m;
    errors.outlier_ratio += std::abs(error) > kMaxOutlierM ? 1.0 : 0.0;
  }
  const double count = static_cast<double>(points.size());
  return {std::sqrt(errors.rmse_m / count), errors.mean_sd_m / count, errors.outlier_ratio / count};
}

// Coefficients of z = a * east + b * north + c that fit best.
Eigen::Vector3d FitPlane(const Points& points) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const DensePoint& point : points) {
    const Eigen::Vector3d p = point.point_in_world.cast<double>();
    const Eigen::Vector3d row(p.x(), p.y(), 1.0);
    normal += row * row.transpose();
    right += row * p.z();
  }
  return normal.ldlt().solve(right);
}

TEST_CASE("stereo: a tilted plane keeps its heights and its slope within 0.5 deg") {
  const Scene scene = SceneOf(Tilted);
  struct Flight {
    const char* name;
    Rigid3d left, right;
  };
  for (const Flight& flight :
       {Flight{"baseline across the image", SceneView({-12, 0, 80}, 0), SceneView({12, 0, 80}, 0)},
        Flight{"baseline up the image", SceneView({0, -12, 80}, 0), SceneView({0, 12, 80}, 0)},
        Flight{"opposite legs", SceneView({0, -12, 80}, 0), SceneView({0, 12, 80}, kPi)},
        Flight{"noisy attitudes and heights",
               SceneView({-12, 3, 80}, 0.3, 6, -5),
               SceneView({12, -2, 83}, 0.1, -4, 4)},
        Flight{"oblique", SceneView({-12, -30, 60}, 0, 25), SceneView({12, -30, 60}, 0, 25)}}) {
    CAPTURE(flight.name);
    const Points points = Reconstruct(scene, flight.left, flight.right);
    REQUIRE(points.size() > kMinNumPoints);
    const HeightErrors errors = Compare(scene, points);
    CHECK(errors.rmse_m < kMaxHeightRmseM);
    CHECK(errors.rmse_m < 1.2 * errors.mean_sd_m);
    CHECK(errors.rmse_m > 0.2 * errors.mean_sd_m);
    CHECK(errors.outlier_ratio < 1e-4);
    const Eigen::Vector3d plane = FitPlane(points);
    const double slope_deg = DegFromRad(std::atan(plane.head<2>().norm()));
    CHECK(std::abs(slope_deg - 5.0) < kMaxSlopeErrorDeg);
    // It rises to the east and nowhere else.
    CHECK(plane.x() > 0.08);
    CHECK(std::abs(plane.y()) < 0.008);
  }
}

TEST_CASE("stereo: lens distortion leaves no bowl") {
  Scene scene = SceneOf(Tilted);
  scene.camera.distortion = DistortionModel::kRadTan;
  scene.camera.coefficients = {-0.25, 0.07, 0.0004, -0.0003};
  SUBCASE("radial-tangential") {}
  SUBCASE("equidistant") {
    scene.camera.distortion = DistortionModel::kEquidistant;
    scene.camera.coefficients = {0.01, -0.004, 0.001, 0.0};
  }
  const Points points =
      Reconstruct(scene, SceneView({-12, 0, 80}, 0.4), SceneView({12, 0, 80}, 0.3));
  REQUIRE(points.size() > kMinNumPoints);
  CHECK(Compare(scene, points).rmse_m < kMaxHeightRmseM);
  CHECK(Compare(scene, points).outlier_ratio < 5e-4);
}

TEST_CASE("stereo: a hill in the east comes out in the east, whichever way the camera is turned") {
  const Scene scene = SceneOf(HillInTheEast);
  for (const double heading : {0.0, kPi / 2, kPi, -kPi / 2}) {
    const Rigid3d west = SceneView({-12, 0, 80}, heading), east = SceneView({12, 0, 80}, heading);
    const AdjustedBlock block = SceneBlock(scene, {west, east});
    const cv::Mat west_image = Render(scene, west, 1), east_image = Render(scene, east, 2);
    for (const bool is_west_left : {true, false}) {
      CAPTURE(heading);
      CAPTURE(is_west_left);
      const Points points = is_west_left
                                ? ReconstructPoints(block, {0, 1, 0.0}, west_image, east_image, {})
                                : ReconstructPoints(block, {1, 0, 0.0}, east_image, west_image, {});
      REQUIRE(points.size() > kMinNumPoints);
      const auto top = std::max_element(points.begin(), points.end(), [](auto& a, auto& b) {
        return a.point_in_world.z() < b.point_in_world.z();
      });
      CHECK((top->point_in_world - Eigen::Vector3f(12, 0, 8)).head<2>().norm() < 3.0f);
      CHECK(std::abs(top->point_in_world.z() - 8.0f) < 0.6f);
      CHECK(Compare(scene, points).rmse_m < kMaxHeightRmseM);
    }
  }
}

TEST_CASE("stereo: a box keeps its walls, and what they hide stays unseen") {
  const Scene scene = SceneOf([](double east, double north) {
    return std::abs(east - 8.0) < 5.0 && std::abs(north + 4.0) < 5.0 ? 6.0 : 0.0;
  });
  const Points points = Reconstruct(scene, SceneView({-12, 0, 80}, 0), SceneView({12, 0, 80}, 0));
  int num_on_top = 0, num_beside = 0, num_between = 0;
  for (const DensePoint& point : points) {
    const double outside_m = std::max(std::abs(point.point_in_world.x() - 8.0),
                                      std::abs(point.point_in_world.y() + 4.0)) -
                             5.0;
    const double z = point.point_in_world.z();
    num_on_top += std::abs(z - 6.0) < 0.6 && outside_m < 0.0 ? 1 : 0;
    num_beside += std::abs(z) < 0.6 && outside_m > 0.0 && outside_m < 5.0 ? 1 : 0;
    // Neither roof nor ground, or on the wrong side of the wall by more than half a block.
    const bool is_roof = z > 3.0;
    num_between += is_roof != (outside_m < 0.0) && std::abs(outside_m) > 1.0 ? 1 : 0;
  }
  CHECK(num_on_top > 1800);
  CHECK(num_beside > 4000);
  CHECK(num_between < 20);
}

TEST_CASE("stereo: exposure may differ by a stop and may burn out") {
  const Scene scene = SceneOf(Tilted);
  const Rigid3d left = SceneView({-12, 0, 80}, 0), right = SceneView({12, 0, 80}, 0);
  const cv::Mat left_image = Render(scene, left, 1), right_image = Render(scene, right, 2);
  for (const double gain : {0.5, 1.6}) {
    CAPTURE(gain);
    cv::Mat exposed;
    right_image.convertTo(exposed, CV_8U, gain);
    const Points points =
        ReconstructPoints(SceneBlock(scene, {left, right}), {0, 1, 0.0}, left_image, exposed, {});
    REQUIRE(points.size() > kMinNumPoints);
    CHECK(Compare(scene, points).outlier_ratio < 1e-4);
  }
}

TEST_CASE("stereo: ground without texture gives no points, however noisy the camera is") {
  Scene scene = SceneOf(Flat);
  scene.texture = GroundTexture(0.0);
  for (const double noise_sd_grey : {0.0, 1.0, 3.0}) {
    CAPTURE(noise_sd_grey);
    scene.noise_sd_grey = noise_sd_grey;
    CHECK(Reconstruct(scene, SceneView({-12, 0, 80}, 0), SceneView({12, 0, 80}, 0)).size() <= 3);
  }
}

TEST_CASE("stereo: two pictures of different places give next to nothing") {
  const Scene scene = SceneOf(Flat);
  const Rigid3d left = SceneView({-12, 0, 80}, 0), right = SceneView({12, 0, 80}, 0);
  const Points points = ReconstructPoints(SceneBlock(scene, {left, right}),
                                          {0, 1, 0.0},
                                          Render(scene, left, 1),
                                          Render(scene, SceneView({90, 70, 80}, 0), 2),
                                          {});
  // About 70000 where the pictures belong together.
  CHECK(points.size() < 500);
}

TEST_CASE("stereo: equal poses are no pair and give no points") {
  const Scene scene = SceneOf(Flat);
  const Rigid3d view = SceneView({0, 0, 80}, 0);
  CHECK(Reconstruct(scene, view, view).empty());
  CHECK(SelectPairs(SceneBlock(scene, {view, view}), {}).empty());
}

TEST_CASE("stereo: an image that is not the camera's is refused by name") {
  const Scene scene = SceneOf(Flat);
  const Rigid3d left = SceneView({-12, 0, 80}, 0), right = SceneView({12, 0, 80}, 0);
  const AdjustedBlock block = SceneBlock(scene, {left, right});
  const cv::Mat image = Render(scene, left, 1);
  CHECK_THROWS_WITH_AS(ReconstructPoints(block, {0, 1, 0.0}, image, image.rowRange(0, 9), {}),
                       "stereo: frame 1: image is 376x9 of type 0, camera says 376x300, 8-bit grey "
                       "or BGR",
                       std::invalid_argument);
}

TEST_CASE("pairs: each connected view gets the partner nearest to the ideal baseline, none twice") {
  const Scene scene = SceneOf(Flat);
  // 6 m apart at 80 m: four steps make the ideal ratio of 0.3.
  std::vector<Rigid3d> poses;
  poses.reserve(9);
  for (int i = 0; i < 9; ++i) poses.push_back(SceneView({6.0 * i - 24.0, 0, 80}, 0));
  AdjustedBlock block = SceneBlock(scene, poses);
  StereoOptions options;
  options.num_partners = 1;
  options.num_pairs_per_place = 0;
  const std::vector<StereoPair> pairs = SelectPairs(block, options);
  std::vector<bool> has_pair(poses.size(), false);
  for (size_t i = 0; i < pairs.size(); ++i) {
    CHECK(pairs[i].left < pairs[i].right);
    CHECK(pairs[i].right - pairs[i].left >= 3);
    CHECK(pairs[i].right - pairs[i].left <= 4);
    has_pair[pairs[i].left] = has_pair[pairs[i].right] = true;
    for (size_t j = 0; j < i; ++j) {
      CHECK((pairs[i].left != pairs[j].left || pairs[i].right != pairs[j].right));
    }
  }
  CHECK(std::count(has_pair.begin(), has_pair.end(), true) == 9);

  block.views[4].is_connected = false;
  for (const StereoPair& pair : SelectPairs(block, options)) {
    CHECK(pair.left != 4);
    CHECK(pair.right != 4);
  }
}

TEST_CASE("pairs: further ones are taken until four show each place") {
  const Scene scene = SceneOf(Flat);
  std::vector<Rigid3d> poses;
  poses.reserve(9);
  for (int i = 0; i < 9; ++i) poses.push_back(SceneView({6.0 * i - 24.0, 0, 80}, 0));
  const AdjustedBlock block = SceneBlock(scene, poses);
  const auto num_with = [&](int num_pairs_per_place) {
    StereoOptions options;
    options.num_pairs_per_place = num_pairs_per_place;
    const std::vector<StereoPair> pairs = SelectPairs(block, options);
    // None twice.
    CHECK(std::adjacent_find(pairs.begin(), pairs.end(), [](const auto& a, const auto& b) {
            return a.left == b.left && a.right == b.right;
          }) == pairs.end());
    return pairs.size();
  };
  CHECK(num_with(0) <= num_with(2));
  CHECK(num_with(2) < num_with(8));
  CHECK(num_with(20) <= 36);
}

TEST_CASE("pairs: views that look apart, or one above the other, are none") {
  const Scene scene = SceneOf(Flat);
  CHECK(
      SelectPairs(
          SceneBlock(scene, {SceneView({-12, 0, 80}, 0, 0, 20), SceneView({12, 0, 80}, 0, 0, -20)}),
          {})
          .empty());
  CHECK(SelectPairs(SceneBlock(scene, {SceneView({0, 0, 60}, 0), SceneView({0, 0, 84}, 0)}), {})
            .empty());
}

TEST_CASE("stereo: Check names field, value and constraint") {
  CHECK_NOTHROW(StereoOptions().Check());
  CHECK(RefusalOf(&StereoOptions::block_size_px, 8) ==
        "stereo.block_size_px = 8: must be odd, in [1, 21]");
  CHECK(IsRefused(&StereoOptions::ground_sampling_distance_m, 0.0, "ground_sampling_distance_m"));
  CHECK(IsRefused(&StereoOptions::ideal_baseline_ratio, 0.05, "ideal_baseline_ratio"));
  CHECK(IsRefused(&StereoOptions::min_baseline_ratio, 0.0, "min_baseline_ratio"));
  CHECK(IsRefused(&StereoOptions::max_baseline_ratio, 6.0, "max_baseline_ratio"));
  CHECK(IsRefused(&StereoOptions::max_axis_angle_deg, 91.0, "max_axis_angle_deg"));
  CHECK(IsRefused(&StereoOptions::num_partners, 0, "num_partners"));
  CHECK(IsRefused(&StereoOptions::min_num_shared_landmarks, 0, "min_num_shared_landmarks"));
  CHECK(IsRefused(&StereoOptions::relief_margin_m, -1.0, "relief_margin_m"));
  CHECK(IsRefused(&StereoOptions::p1_factor, 0, "p1_factor"));
  CHECK(IsRefused(&StereoOptions::p2_factor, 8, "p2_factor"));
  CHECK(IsRefused(&StereoOptions::uniqueness_ratio_percent, 100, "uniqueness_ratio_percent"));
  CHECK(IsRefused(&StereoOptions::speckle_size_px, -1, "speckle_size_px"));
  CHECK(
      IsRefused(&StereoOptions::max_left_right_difference_px, -1, "max_left_right_difference_px"));
  CHECK(IsRefused(&StereoOptions::min_texture_grey, -0.1, "min_texture_grey"));
  CHECK(IsRefused(&StereoOptions::correlation_window_px, 10, "correlation_window_px"));
  CHECK(IsRefused(&StereoOptions::min_correlation, 1.0, "min_correlation"));
  CHECK(IsRefused(&StereoOptions::max_num_disparities, 8, "max_num_disparities"));
  CHECK(IsRefused(&StereoOptions::max_points_per_m2, 0.0, "max_points_per_m2"));
  CHECK(IsRefused(&StereoOptions::disparity_sd_px, 0.0, "disparity_sd_px"));
}

}  // namespace
}  // namespace freelsd
