#include "engine/adjustment/solver.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include <ceres/ceres.h>

#include "engine/adjustment/residuals.h"

namespace freelsd {
namespace {

// GPS and autopilot may be off by more than they say; beyond this many deviations a prior pulls
// less.
constexpr double kPriorLossSd = 2.5;
// No prior is trusted better than this, whatever its deviation says.
constexpr double kMinPositionSdM = 0.01;
constexpr double kMinAttitudeSdDeg = 0.01;
// Up to here a dense reduced system is solved faster than a sparse one.
constexpr size_t kMaxNumDenseViews = 60;

// Intrinsics, then rotation and position of each view, then the readout of each: everything but the
// points, in one piece of memory: Ceres orders parameter blocks by address, and
// sums, hence last digits, follow that order.
class Parameters {
 public:
  Parameters(const BlockState& start, const Camera& camera) : values_(2, 1.0) {
    values_[0] = start.camera.fx_px / camera.fx_px;
    values_[1] = FirstRadial(start.camera) - FirstRadial(camera);
    for (const Rigid3d& world_from_camera : start.world_from_camera) {
      const auto& quaternion = world_from_camera.rotation.coeffs();
      values_.insert(values_.end(), quaternion.data(), quaternion.data() + 4);
      const Eigen::Vector3d& position = world_from_camera.translation;
      values_.insert(values_.end(), position.data(), position.data() + 3);
    }
    for (const Readout& readout : start.readouts) {
      values_.insert(values_.end(), readout.turn.data(), readout.turn.data() + 3);
    }
  }

  size_t num_views() const { return (values_.size() - 2) / 10; }
  double* Intrinsics() { return values_.data(); }
  double* Rotation(size_t view) { return values_.data() + 2 + 7 * view; }
  double* Position(size_t view) { return Rotation(view) + 4; }
  double* ReadoutOf(size_t view) { return values_.data() + 2 + 7 * num_views() + 3 * view; }
  const std::vector<double>& values() const { return values_; }

 private:
  static double FirstRadial(const Camera& camera) {
    return camera.coefficients.empty() ? 0.0 : camera.coefficients[0];
  }

  std::vector<double> values_;
};

void AddPriors(const std::vector<View>& views,
               const AdjustmentOptions& options,
               Parameters& parameters,
               ceres::Problem& problem) {
  auto* loss = new ceres::HuberLoss(kPriorLossSd);
  for (size_t i = 0; i < views.size(); ++i) {
    const View& view = views[i];
    const double position_sd_m = std::max(view.position_sd_m, kMinPositionSdM);
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<PositionPrior, 3, 3>(
                                 new PositionPrior{view.prior_position_in_world, position_sd_m}),
                             loss,
                             parameters.Position(i));
    const AttitudeDeviation deviation = AttitudeDeviationOf(view, options);
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<AttitudePrior, 3, 4>(
            new AttitudePrior{view.prior_world_from_camera, deviation.tilt_sd, deviation.yaw_sd}),
        loss,
        parameters.Rotation(i));
    problem.SetManifold(parameters.Rotation(i), new ceres::EigenQuaternionManifold);
  }
  problem.AddResidualBlock(new ceres::AutoDiffCostFunction<IntrinsicsPrior, 2, 2>(
                               new IntrinsicsPrior{options.focal_sd_ratio, options.radial_sd}),
                           nullptr,
                           parameters.Intrinsics());
}

// How long a rolling shutter may take; 0 when all rows are exposed at once.
double ReadoutSeconds(const Camera& camera, const AdjustmentOptions& options) {
  const bool is_unknown = camera.source == CameraSource::kExif && camera.readout_s == 0.0;
  return is_unknown ? options.exif_readout_s : camera.readout_s;
}

void AddReadouts(const Camera& camera,
                 const AdjustmentOptions& options,
                 Parameters& parameters,
                 ceres::Problem& problem) {
  const double turn_sd =
      ReadoutSeconds(camera, options) * RadFromDeg(options.readout_rate_sd_deg_s);
  for (size_t i = 0; i < parameters.num_views(); ++i) {
    problem.AddParameterBlock(parameters.ReadoutOf(i), 3);
    if (turn_sd == 0.0) {
      problem.SetParameterBlockConstant(parameters.ReadoutOf(i));
      continue;
    }
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<ReadoutPrior, 3, 3>(new ReadoutPrior{turn_sd}),
        nullptr,
        parameters.ReadoutOf(i));
  }
}

void AddObservations(const Camera& camera,
                     double loss_px,
                     std::vector<BlockTrack>& tracks,
                     Parameters& parameters,
                     ceres::Problem& problem) {
  auto* loss = new ceres::CauchyLoss(loss_px);
  for (BlockTrack& track : tracks) {
    if (!track.has_point) continue;
    for (const Sighting& sighting : track.sightings) {
      if (!sighting.is_inlier) continue;
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<ReprojectionResidual, 2, 4, 3, 3, 2, 3>(
              new ReprojectionResidual(&camera, sighting.point_in_image)),
          loss,
          parameters.Rotation(sighting.view),
          parameters.Position(sighting.view),
          track.point_in_world.data(),
          parameters.Intrinsics(),
          parameters.ReadoutOf(sighting.view));
    }
  }
}

// The camera with the refined factor and radial change applied.
Camera Refined(const Camera& camera, const double* intrinsics) {
  Camera refined = camera;
  refined.fx_px *= intrinsics[0];
  refined.fy_px *= intrinsics[0];
  if (intrinsics[1] == 0.0) return refined;
  if (refined.distortion == DistortionModel::kNone) {
    refined.distortion = DistortionModel::kRadTan;
    refined.coefficients = {0.0, 0.0, 0.0, 0.0};
  }
  refined.coefficients[0] += intrinsics[1];
  return refined;
}

// An equidistant lens has no EXIF tag: its intrinsics were measured.
bool MayRefine(const Camera& camera, const AdjustmentOptions& options) {
  return options.refine_exif_intrinsics && camera.source == CameraSource::kExif &&
         camera.distortion != DistortionModel::kEquidistant;
}

ceres::Solver::Options SolverOptions(const AdjustmentOptions& options,
                                     const SolverSettings& settings,
                                     std::vector<BlockTrack>& tracks,
                                     Parameters& parameters) {
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  for (BlockTrack& track : tracks) {
    if (track.has_point) ordering->AddElementToGroup(track.point_in_world.data(), 0);
  }
  for (size_t i = 0; i < parameters.num_views(); ++i) {
    ordering->AddElementToGroup(parameters.Rotation(i), 1);
    ordering->AddElementToGroup(parameters.Position(i), 1);
    ordering->AddElementToGroup(parameters.ReadoutOf(i), 1);
  }
  ordering->AddElementToGroup(parameters.Intrinsics(), 1);
  ceres::Solver::Options solver;
  solver.linear_solver_ordering = ordering;
  solver.linear_solver_type =
      parameters.num_views() <= kMaxNumDenseViews ? ceres::DENSE_SCHUR : ceres::SPARSE_SCHUR;
  solver.max_num_iterations = options.max_num_iterations;
  solver.function_tolerance = settings.function_tolerance;
  // More threads would sum in another order on each run, and the last digits would differ.
  solver.num_threads = 1;
  solver.logging_type = ceres::SILENT;
  return solver;
}

bool IsFinite(const Parameters& parameters, const std::vector<BlockTrack>& tracks) {
  const auto is_finite = [](double value) { return std::isfinite(value); };
  const std::vector<double>& values = parameters.values();
  return std::all_of(values.begin(), values.end(), is_finite) &&
         std::all_of(tracks.begin(), tracks.end(), [](const BlockTrack& track) {
           return !track.has_point || track.point_in_world.allFinite();
         });
}

}  // namespace

AttitudeDeviation AttitudeDeviationOf(const View& view, const AdjustmentOptions& options) {
  const bool is_given = view.attitude_source == AttitudeSource::kGiven;
  const double given_sd_deg = std::max(view.attitude_sd_deg, kMinAttitudeSdDeg);
  return {RadFromDeg(is_given ? given_sd_deg : options.estimated_tilt_sd_deg),
          RadFromDeg(is_given ? given_sd_deg : options.estimated_yaw_sd_deg)};
}

std::optional<BlockState> SolveBlock(const std::vector<View>& views,
                                     const Camera& camera,
                                     const BlockState& start,
                                     const AdjustmentOptions& options,
                                     const SolverSettings& settings,
                                     std::vector<BlockTrack>& tracks) {
  Parameters parameters(start, camera);
  ceres::Problem problem;
  AddPriors(views, options, parameters, problem);
  AddReadouts(camera, options, parameters, problem);
  AddObservations(camera, settings.loss_px, tracks, parameters, problem);
  if (!MayRefine(camera, options)) problem.SetParameterBlockConstant(parameters.Intrinsics());
  ceres::Solver::Summary summary;
  ceres::Solve(SolverOptions(options, settings, tracks, parameters), &problem, &summary);
  if (!summary.IsSolutionUsable() || !IsFinite(parameters, tracks)) return std::nullopt;
  if (parameters.Intrinsics()[0] <= 0.0) return std::nullopt;
  BlockState solved{Refined(camera, parameters.Intrinsics()), {}, {}};
  for (size_t i = 0; i < views.size(); ++i) {
    solved.world_from_camera.push_back(
        {Eigen::Quaterniond(Eigen::Map<const Eigen::Vector4d>(parameters.Rotation(i))).normalized(),
         Eigen::Map<const Eigen::Vector3d>(parameters.Position(i))});
    solved.readouts.push_back({Eigen::Map<const Eigen::Vector3d>(parameters.ReadoutOf(i))});
  }
  return solved;
}

}  // namespace freelsd
