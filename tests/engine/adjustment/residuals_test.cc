#include "engine/adjustment/residuals.h"

#include <stdexcept>
#include <utility>
#include <vector>

#include <ceres/autodiff_cost_function.h>
#include <doctest/doctest.h>

#include "engine/adjustment/reprojection_cost.h"
#include "tests/engine/adjustment/survey.h"
#include "tests/engine/refusal.h"

namespace freelsd {
namespace {

TEST_CASE("adjustment: the residual projects as the camera does, for every lens") {
  Camera camera = SurveyCamera();
  const Rigid3d world_from_camera{NadirCamera(0.7), {3.0, -4.0, 90.0}};
  const Eigen::Vector3d point(31.0, 12.0, 2.0);
  camera.readout.turns << 0.01, -0.03, 0.05, 0.02, -0.04, -0.02, 0.02, -0.01, 0.03, 0.05, 0.005,
      0.004, 0.01, -0.02, 0.03;
  for (const auto& [model, coefficients] :
       {std::pair{DistortionModel::kNone, std::vector<double>{}},
        std::pair{DistortionModel::kRadTan, std::vector<double>{-0.2, 0.05, 1e-3, -2e-3, 0.01}},
        std::pair{DistortionModel::kEquidistant, std::vector<double>{0.02, -0.01, 3e-3, 1e-3}}}) {
    camera.distortion = model;
    camera.coefficients = coefficients;
    const auto pixel = camera.ImageFromCamera(Inverse(world_from_camera) * point);
    REQUIRE(pixel);
    // The residual takes the share of the readout from the sighting's row, so they must be the
    // same.
    const Eigen::Vector2d sighting = *pixel - Eigen::Vector2d(3.0, 0.0);
    const ReprojectionResidual residual(&camera, sighting);
    const double lens[kNumLensParameters] = {1.0};
    Eigen::Matrix<double, kNumReadoutParameters, 1> readout;
    readout << camera.readout.turns.reshaped();
    double error[2];
    Eigen::Matrix<double, kNumPoseParameters, 1> pose;
    pose << world_from_camera.rotation.coeffs(), world_from_camera.translation;
    REQUIRE(residual(pose.data(), point.data(), lens, readout.data(), error));
    CHECK(error[0] == doctest::Approx(3.0).epsilon(1e-4));
    CHECK(std::abs(error[1]) < 1e-4);
  }
}

// Derivatives of the residual by each parameter block, one after the other.
std::vector<double> Derivatives(const ceres::CostFunction& cost,
                                const std::vector<std::vector<double>>& blocks) {
  std::vector<const double*> parameters;
  std::vector<std::vector<double>> jacobians;
  std::vector<double*> to;
  to.reserve(blocks.size());
  for (const std::vector<double>& block : blocks) {
    parameters.push_back(block.data());
    jacobians.emplace_back(2 * block.size());
  }
  for (std::vector<double>& jacobian : jacobians) to.push_back(jacobian.data());
  double residuals[2];
  REQUIRE(cost.Evaluate(parameters.data(), residuals, to.data()));
  std::vector<double> all(residuals, residuals + 2);
  for (const std::vector<double>& jacobian : jacobians) {
    all.insert(all.end(), jacobian.begin(), jacobian.end());
  }
  return all;
}

TEST_CASE("adjustment: derivatives by hand are those found automatically, for every lens") {
  Camera camera = SurveyCamera();
  // Else one could stand for the other.
  camera.fy_px = 790.0;
  const Eigen::Vector4d q = NadirCamera(0.7).coeffs();
  const std::vector<std::vector<double>> blocks = {{q[0], q[1], q[2], q[3], 3.0, -4.0, 90.0},
                                                   {31.0, 12.0, 2.0},
                                                   {1.02, 0.03, -0.01, 2e-3, -1e-3, 0.01, -0.02},
                                                   {0.01,
                                                    -0.02,
                                                    0.005,
                                                    -0.03,
                                                    0.015,
                                                    0.02,
                                                    0.05,
                                                    0.04,
                                                    -0.03,
                                                    0.02,
                                                    0.01,
                                                    -0.04,
                                                    0.03,
                                                    -0.06,
                                                    0.02}};
  for (const auto& [each, coefficients] :
       {std::pair{DistortionModel::kNone, std::vector<double>{}},
        std::pair{DistortionModel::kRadTan, std::vector<double>{-0.2, 0.05, 1e-3, -2e-3, 0.01}},
        std::pair{DistortionModel::kEquidistant, std::vector<double>{0.02, -0.01, 3e-3, 1e-3}}}) {
    const DistortionModel model = each;
    CAPTURE(static_cast<int>(model));
    camera.distortion = model;
    camera.coefficients = coefficients;
    const Eigen::Vector2d sighting(140.0, 60.0);
    using Automatic = ceres::AutoDiffCostFunction<ReprojectionResidual,
                                                  2,
                                                  kNumPoseParameters,
                                                  3,
                                                  kNumLensParameters,
                                                  kNumReadoutParameters>;
    const std::vector<double> expected =
        Derivatives(Automatic(new ReprojectionResidual(&camera, sighting)), blocks);
    const std::vector<double> by_hand = Derivatives(ReprojectionCost(&camera, sighting), blocks);
    for (size_t i = 0; i < expected.size(); ++i) {
      CAPTURE(i);
      CHECK(by_hand[i] == doctest::Approx(expected[i]).epsilon(1e-9));
    }
  }
}

TEST_CASE("adjustment: Check names field, value and constraint") {
  CHECK_NOTHROW(AdjustmentOptions().Check());
  CHECK(RefusalOf(&AdjustmentOptions::max_tilt_sd_deg, 0.0) ==
        "adjustment.max_tilt_sd_deg = 0: must be in (0, 90]");
  CHECK(IsRefused(&AdjustmentOptions::min_num_track_connections, 0, "min_num_track_connections"));
  CHECK(IsRefused(&AdjustmentOptions::min_baseline_m, 0.0, "min_baseline_m"));
  CHECK(IsRefused(&AdjustmentOptions::max_baseline_ratio, 0.0, "max_baseline_ratio"));
  CHECK(IsRefused(&AdjustmentOptions::robust_loss_px, 0.0, "robust_loss_px"));
  CHECK(
      IsRefused(&AdjustmentOptions::max_reprojection_error_px, -1.0, "max_reprojection_error_px"));
  CHECK(IsRefused(
      &AdjustmentOptions::max_reprojection_error_sigma, 2.0, "max_reprojection_error_sigma"));
  CHECK(IsRefused(&AdjustmentOptions::focal_sd_ratio, 0.6, "focal_sd_ratio"));
  CHECK(IsRefused(&AdjustmentOptions::radial_sd, 0.0, "radial_sd"));
  CHECK(IsRefused(&AdjustmentOptions::tangential_sd, 0.0, "tangential_sd"));
  CHECK(IsRefused(&AdjustmentOptions::principal_point_sd_ratio, 0.6, "principal_point_sd_ratio"));
  CHECK(IsRefused(&AdjustmentOptions::min_num_lens_views, 0, "min_num_lens_views"));
  CHECK(IsRefused(&AdjustmentOptions::max_num_iterations, 0, "max_num_iterations"));
  CHECK(IsRefused(&AdjustmentOptions::function_tolerance, 0.0, "function_tolerance"));
  CHECK(IsRefused(&AdjustmentOptions::readout_change_sd_deg_s2, 0.0, "readout_change_sd_deg_s2"));
  CHECK(IsRefused(&AdjustmentOptions::max_readout_power, 6, "max_readout_power"));
  CHECK(IsRefused(&AdjustmentOptions::estimated_tilt_sd_deg, 0.0, "estimated_tilt_sd_deg"));
  CHECK(IsRefused(&AdjustmentOptions::estimated_yaw_sd_deg, 181.0, "estimated_yaw_sd_deg"));
  CHECK(IsRefused(&AdjustmentOptions::min_num_shared_landmarks, 0, "min_num_shared_landmarks"));
  CHECK(IsRefused(&AdjustmentOptions::min_num_view_observations, 2, "min_num_view_observations"));
  CHECK(IsRefused(&AdjustmentOptions::min_num_connected_views, 1, "min_num_connected_views"));
  CHECK(
      IsRefused(&AdjustmentOptions::min_position_spread_sigma, -0.1, "min_position_spread_sigma"));
  CHECK(IsRefused(&AdjustmentOptions::num_threads, 0, "num_threads"));
}

}  // namespace
}  // namespace freelsd
