#include "engine/adjustment/adjustment.h"

#include <algorithm>
#include <stdexcept>

#include <doctest/doctest.h>

#include "tests/engine/adjustment/survey.h"

namespace freelsd {
namespace {

// Root mean square height of the landmarks over the true ground below them.
double HeightError(const AdjustedBlock& block, double relief_m) {
  double sum = 0.0;
  for (const Landmark& landmark : block.landmarks) {
    const Eigen::Vector3d& p = landmark.point_in_world;
    sum += std::pow(p.z() - SurveyGround(p.x(), p.y(), relief_m), 2);
  }
  return std::sqrt(sum / static_cast<double>(block.landmarks.size()));
}

void CheckIsPrior(const AdjustedBlock& block, const Survey& survey) {
  CHECK_FALSE(block.is_usable);
  CHECK_FALSE(block.note.empty());
  CHECK(block.landmarks.empty());
  REQUIRE(block.views.size() == survey.views.size());
  for (size_t i = 0; i < block.views.size(); ++i) {
    CHECK_FALSE(block.views[i].is_connected);
    CHECK(block.views[i].world_from_camera.translation ==
          survey.views[i].world_from_camera.translation);
    CHECK(block.views[i].world_from_camera.rotation.coeffs() ==
          survey.views[i].world_from_camera.rotation.coeffs());
  }
}

TEST_CASE("adjustment: good positions and noisy attitudes give poses to decimetres") {
  SurveyOptions options;
  options.gps_sd_m = 0.05;
  // A wrong match along the epipolar line of a track of two views cannot be told from relief.
  options.outlier_ratio = 0.0;
  const Survey survey = MakeSurvey(options);
  const AdjustedBlock block = AdjustPoses(survey.views, survey.camera, {});
  REQUIRE(block.is_usable);
  CHECK(NumConnected(block) == 24);
  CHECK(block.rms_before_px > 10.0 * kNoisePx);
  CHECK(block.rms_after_px < kMaxRmsPx);
  const ShapeError error = CompareWithTruth(survey, block);
  CHECK(error.shift_m < 0.05);
  CHECK(error.max_position_m < 0.2);
  CHECK(error.max_attitude_deg < 0.1);
  CHECK(HeightError(block, options.relief_m) < 0.3);
  for (const AdjustedView& view : block.views) {
    CHECK(view.height_above_ground == doctest::Approx(100.0).epsilon(0.1));
    CHECK(std::is_sorted(view.landmarks.begin(), view.landmarks.end()));
  }
}

TEST_CASE("adjustment: landmarks scatter as much as their height deviation says") {
  SurveyOptions options;
  options.gps_sd_m = 0.01;
  options.outlier_ratio = 0.0;
  const Survey survey = MakeSurvey(options);
  const AdjustedBlock block = AdjustPoses(survey.views, survey.camera, {});
  double sum = 0.0;
  for (const Landmark& landmark : block.landmarks) {
    const Eigen::Vector3d& p = landmark.point_in_world;
    sum +=
        std::pow((p.z() - SurveyGround(p.x(), p.y(), options.relief_m)) / landmark.height_sd_m, 2);
  }
  const double ratio = std::sqrt(sum / static_cast<double>(block.landmarks.size()));
  CHECK(ratio > 0.5);
  CHECK(ratio < 1.3);
}

TEST_CASE("adjustment: attitudes 10 and 20 deg off, heights 20 % off, GPS 3 m off still converge") {
  for (const double height_factor : {0.8, 1.2}) {
    CAPTURE(height_factor);
    SurveyOptions options;
    options.seed = height_factor < 1.0 ? 2 : 3;
    options.num_points = 700;
    options.outlier_ratio = 0.08;
    options.gps_sd_m = 3.0;
    options.start_yaw_error_deg = 20.0;
    options.start_tilt_error_deg = 10.0;
    options.height_factor = height_factor;
    options.attitude_source = AttitudeSource::kEstimated;
    const Survey survey = MakeSurvey(options);
    const AdjustedBlock block = AdjustPoses(survey.views, survey.camera, {});
    REQUIRE(block.is_usable);
    CHECK(NumConnected(block) == 24);
    CHECK(block.rms_after_px < kMaxRmsPx);
    const ShapeError error = CompareWithTruth(survey, block);
    // What is left is what GPS of 3 m says about the tilt and scale of a block of 200 m.
    CHECK(error.shift_m < 2.0);
    CHECK(error.max_position_m < 3.5);
    CHECK(error.max_attitude_deg < 2.5);
    CHECK(error.max_attitude_deg < 3.0 * block.tilt_sd_deg);
    CHECK(HeightError(block, options.relief_m) < 4.0);
  }
}

TEST_CASE("adjustment: an EXIF camera gets its focal length and first radial coefficient back") {
  SurveyOptions options;
  options.gps_sd_m = 0.3;
  SurveyMaker maker(options);
  Survey survey = maker.Make();
  Camera truth = survey.camera;
  truth.fx_px = truth.fy_px = 824.0;
  truth.distortion = DistortionModel::kRadTan;
  truth.coefficients = {-0.06, 0.0, 0.0, 0.0};
  maker.Observe(truth, survey);

  SUBCASE("refined") {
    survey.camera.source = CameraSource::kExif;
    const AdjustedBlock block = AdjustPoses(survey.views, survey.camera, {});
    REQUIRE(block.is_usable);
    CHECK(block.camera.fx_px == doctest::Approx(truth.fx_px).epsilon(0.01));
    CHECK(block.camera.fy_px == block.camera.fx_px);
    REQUIRE(block.camera.distortion == DistortionModel::kRadTan);
    CHECK(block.camera.coefficients[0] == doctest::Approx(-0.06).epsilon(0.05));
    CHECK_NOTHROW(block.camera.Check());
    CHECK(block.rms_after_px < kMaxRmsPx);
  }
  SUBCASE("a calibrated camera is left alone") {
    const AdjustedBlock block = AdjustPoses(survey.views, survey.camera, {});
    CHECK(block.camera.fx_px == survey.camera.fx_px);
    CHECK(block.camera.coefficients.empty());
  }
}

TEST_CASE(
    "adjustment: a lens off its middle is found from twenty views on, and not bent into poses") {
  SurveyOptions options;
  options.gps_sd_m = 0.3;
  SurveyMaker maker(options);
  Survey survey = maker.Make();
  Camera truth = survey.camera;
  truth.cx_px += 9.0;
  truth.cy_px -= 14.0;
  truth.distortion = DistortionModel::kRadTan;
  truth.coefficients = {-0.06, 0.03, 2e-3, -1.5e-3};
  maker.Observe(truth, survey);
  survey.camera.source = CameraSource::kExif;
  const AdjustedBlock block = AdjustPoses(survey.views, survey.camera, {});
  REQUIRE(block.is_usable);
  CHECK(block.rms_after_px < kMaxRmsPx);
  // Principal point and tangential distortion make up for one another; together they are sharp.
  for (const Eigen::Vector2d& corner :
       {Eigen::Vector2d(20.0, 20.0), Eigen::Vector2d(980.0, 730.0)}) {
    const Eigen::Vector2d error_normalized =
        block.camera.NormalizedFromImage(corner) - truth.NormalizedFromImage(corner);
    CHECK(error_normalized.norm() * truth.fx_px < 6.0);
  }
  AdjustmentOptions focal_only;
  focal_only.min_num_lens_views = 25;
  const AdjustedBlock bent = AdjustPoses(survey.views, survey.camera, focal_only);
  CHECK(bent.camera.cx_px == survey.camera.cx_px);
  CHECK(bent.rms_after_px > 1.05 * block.rms_after_px);
  CHECK(CompareWithTruth(survey, block).max_attitude_deg <
        0.5 * CompareWithTruth(survey, bent).max_attitude_deg);
}

TEST_CASE("adjustment: one GPS fix 40 m off does not bend the block") {
  SurveyOptions options;
  options.gps_sd_m = 0.5;
  Survey survey = MakeSurvey(options);
  survey.views[9].prior_position_in_world += Eigen::Vector3d(40.0, 0.0, 0.0);
  survey.views[9].world_from_camera.translation += Eigen::Vector3d(40.0, 0.0, 0.0);
  const AdjustedBlock block = AdjustPoses(survey.views, survey.camera, {});
  REQUIRE(block.is_usable);
  CHECK(CompareWithTruth(survey, block).max_position_m < 1.0);
}

TEST_CASE("adjustment: geotags that lag the shutter show in the position's deviation") {
  SurveyOptions options;
  options.num_points = 500;
  options.gps_sd_m = 0.5;
  Survey survey = MakeSurvey(options);
  const double before_m = AdjustPoses(survey.views, survey.camera, {}).views[0].position_sd_m;
  for (size_t i = 0; i < survey.views.size(); ++i) {
    // 12 m back along the strip, whose direction alternates.
    const double lag_m = i / static_cast<size_t>(options.num_per_strip) % 2 == 0 ? -12.0 : 12.0;
    survey.views[i].prior_position_in_world.x() += lag_m;
    survey.views[i].world_from_camera.translation.x() += lag_m;
  }
  const AdjustedBlock block = AdjustPoses(survey.views, survey.camera, {});
  CHECK(before_m < 0.5);
  REQUIRE(block.is_usable);
  CHECK(block.views[0].position_sd_m > 2.0);
}

TEST_CASE("adjustment: a hover has no scale, whatever its GPS noise pretends") {
  for (const double gps_sd_m : {0.0, 2.0}) {
    CAPTURE(gps_sd_m);
    SurveyOptions options;
    options.num_strips = 1;
    options.num_points = 400;
    options.spacing_m = 0.0;
    options.gps_sd_m = gps_sd_m;
    Survey survey = MakeSurvey(options);
    for (View& view : survey.views) view.position_sd_m = 2.0;
    CheckIsPrior(AdjustPoses(survey.views, survey.camera, {}), survey);
  }
}

TEST_CASE("adjustment: equal poses, one view and views without tracks give priors and a reason") {
  SurveyOptions options;
  options.num_strips = 1;
  options.num_points = 200;
  Survey survey = MakeSurvey(options);
  SUBCASE("equal poses") {
    for (View& view : survey.views) view = survey.views[0];
    CheckIsPrior(AdjustPoses(survey.views, survey.camera, {}), survey);
  }
  SUBCASE("one view") {
    survey.views.resize(1);
    CheckIsPrior(AdjustPoses(survey.views, survey.camera, {}), survey);
  }
  SUBCASE("no tracks") {
    for (View& view : survey.views) view.observations.clear();
    CheckIsPrior(AdjustPoses(survey.views, survey.camera, {}), survey);
  }
  SUBCASE("matches that are all wrong") {
    for (View& view : survey.views) {
      for (Observation& seen : view.observations) {
        seen.track_id = (seen.track_id * 7919 + seen.track_id * std::stoi(view.frame_id)) % 200;
      }
    }
    CheckIsPrior(AdjustPoses(survey.views, survey.camera, {}), survey);
  }
  SUBCASE("no views") {
    CHECK_THROWS_AS(AdjustPoses({}, survey.camera, {}), std::invalid_argument);
  }
}

TEST_CASE("adjustment: a view that shares no tracks keeps its prior and is not connected") {
  SurveyOptions options;
  options.num_points = 500;
  Survey survey = MakeSurvey(options);
  for (Observation& seen : survey.views[5].observations) seen.track_id += 100000;
  survey.views[6].observations.resize(6);
  const AdjustedBlock block = AdjustPoses(survey.views, survey.camera, {});
  REQUIRE(block.is_usable);
  CHECK(NumConnected(block) == 22);
  for (const size_t loose : {size_t{5}, size_t{6}}) {
    CHECK_FALSE(block.views[loose].is_connected);
    CHECK(block.views[loose].landmarks.empty());
    CHECK(block.views[loose].position_sd_m == options.gps_sd_m);
    CHECK(block.views[loose].world_from_camera.translation ==
          survey.views[loose].world_from_camera.translation);
  }
}

TEST_CASE("adjustment: a straight line of views needs attitudes to know the roll around it") {
  SurveyOptions options;
  options.num_strips = 1;
  options.num_per_strip = 8;
  options.num_points = 500;
  SUBCASE("given") {
    const Survey survey = MakeSurvey(options);
    const AdjustedBlock block = AdjustPoses(survey.views, survey.camera, {});
    CHECK(block.is_usable);
    // The attitudes' own 2 deg, hardly helped by 2 m of lever arm.
    CHECK(block.tilt_sd_deg > 1.5);
    CHECK(block.tilt_sd_deg <= 2.0);
  }
  SUBCASE("estimated") {
    options.attitude_source = AttitudeSource::kEstimated;
    const Survey survey = MakeSurvey(options);
    const AdjustedBlock block = AdjustPoses(survey.views, survey.camera, {});
    CheckIsPrior(block, survey);
    CHECK(block.note.find("tilt") != std::string::npos);
  }
}

TEST_CASE("adjustment: the same views give the same bytes for any number of threads") {
  SurveyOptions options;
  options.num_points = 300;
  const Survey survey = MakeSurvey(options);
  const AdjustedBlock one = AdjustPoses(survey.views, survey.camera, {});
  AdjustmentOptions threaded;
  threaded.num_threads = 4;
  const AdjustedBlock four = AdjustPoses(survey.views, survey.camera, threaded);
  REQUIRE(one.landmarks.size() == four.landmarks.size());
  for (size_t i = 0; i < one.views.size(); ++i) {
    CHECK(one.views[i].world_from_camera.translation ==
          four.views[i].world_from_camera.translation);
  }
  for (size_t i = 0; i < one.landmarks.size(); ++i) {
    CHECK(one.landmarks[i].point_in_world == four.landmarks[i].point_in_world);
  }
}

TEST_CASE("adjustment: two surveys without a common landmark are two groups") {
  SurveyOptions options;
  options.num_points = 500;
  options.outlier_ratio = 0.0;
  Survey survey = MakeSurvey(options);
  for (size_t i = 12; i < survey.views.size(); ++i) {
    for (Observation& seen : survey.views[i].observations) seen.track_id += 100000;
  }
  const AdjustedBlock block = AdjustPoses(survey.views, survey.camera, {});
  REQUIRE(NumConnected(block) == 24);
  for (size_t i = 0; i < block.views.size(); ++i) CHECK(block.views[i].group == (i < 12 ? 0 : 1));
}

TEST_CASE("adjustment: a second run on the first one's poses does not drift away from the priors") {
  SurveyOptions options;
  options.num_strips = 2;
  Survey survey = MakeSurvey(options);
  const AdjustedBlock once = AdjustPoses(survey.views, survey.camera, {});
  for (size_t i = 0; i < survey.views.size(); ++i) {
    survey.views[i].world_from_camera = once.views[i].world_from_camera;
  }
  const AdjustedBlock twice = AdjustPoses(survey.views, survey.camera, {});
  constexpr double kMaxDriftM = 0.05;
  for (size_t i = 0; i < survey.views.size(); ++i) {
    CHECK(
        (twice.views[i].world_from_camera.translation - once.views[i].world_from_camera.translation)
            .norm() < kMaxDriftM);
  }
}

}  // namespace
}  // namespace freelsd
