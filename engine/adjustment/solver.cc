#include "engine/adjustment/solver.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include <ceres/ceres.h>

#include "engine/adjustment/reprojection_cost.h"
#include "engine/adjustment/residuals.h"

namespace freelsd {
namespace {

// GPS and autopilot may be worse than their stated deviation. Beyond this many deviations the pull
// of a prior weakens.
constexpr double kPriorLossSd = 2.5;
// Lower bound of the deviation of every prior.
constexpr double kMinPositionSdM = 0.01;
constexpr double kMinAttitudeSdDeg = 0.01;
// Up to this number, the dense reduced system is faster than the sparse one.
constexpr size_t kMaxNumDenseViews = 60;

// Change of the lens from the given camera to the start of a solution.
std::array<double, kNumLensParameters> LensChange(const Camera& given, const Camera& start) {
  const auto change = [&](size_t i) {
    const auto at = [i](const Camera& camera) {
      return i < camera.coefficients.size() ? camera.coefficients[i] : 0.0;
    };
    return at(start) - at(given);
  };
  return {start.fx_px / given.fx_px,
          change(0),
          change(1),
          change(2),
          change(3),
          (start.cx_px - given.cx_px) / given.fx_px,
          (start.cy_px - given.cy_px) / given.fy_px};
}

// All parameters except the points, in one piece of memory: lens, then the pose of each view, then
// the readout of each view. Ceres orders parameter blocks by address. One piece of memory keeps
// this order, and so the last digits of sums, the same in every run.
class Parameters {
 public:
  Parameters(const BlockState& start, const Camera& camera) {
    const std::array<double, kNumLensParameters> lens = LensChange(camera, start.camera);
    values_.assign(lens.begin(), lens.end());
    for (const Rigid3d& world_from_camera : start.world_from_camera) {
      const auto& quaternion = world_from_camera.rotation.coeffs();
      values_.insert(values_.end(), quaternion.data(), quaternion.data() + 4);
      const Eigen::Vector3d& position = world_from_camera.translation;
      values_.insert(values_.end(), position.data(), position.data() + 3);
    }
    for (const Readout& readout : start.readouts) {
      values_.insert(
          values_.end(), readout.turns.data(), readout.turns.data() + kNumReadoutParameters);
    }
  }

  size_t num_views() const {
    return (values_.size() - kNumLensParameters) / (kNumPoseParameters + kNumReadoutParameters);
  }
  double* Lens() { return values_.data(); }
  double* Pose(size_t view) {
    return values_.data() + kNumLensParameters + kNumPoseParameters * view;
  }
  double* ReadoutOf(size_t view) { return Pose(num_views()) + kNumReadoutParameters * view; }
  const std::vector<double>& values() const { return values_; }

 private:
  std::vector<double> values_;
};

using PoseManifold =
    ceres::ProductManifold<ceres::EigenQuaternionManifold, ceres::EuclideanManifold<3>>;

void AddPriors(const std::vector<View>& views,
               const AdjustmentOptions& options,
               Parameters& parameters,
               ceres::Problem& problem) {
  auto* loss = new ceres::HuberLoss(kPriorLossSd);
  for (size_t i = 0; i < views.size(); ++i) {
    const View& view = views[i];
    const double position_sd_m = std::max(view.position_sd_m, kMinPositionSdM);
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<PositionPrior, 3, kNumPoseParameters>(
                                 new PositionPrior{view.prior_position_in_world, position_sd_m}),
                             loss,
                             parameters.Pose(i));
    const AttitudeDeviation deviation = AttitudeDeviationOf(view, options);
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<AttitudePrior, 3, kNumPoseParameters>(
            new AttitudePrior{view.prior_world_from_camera, deviation.tilt_sd, deviation.yaw_sd}),
        loss,
        parameters.Pose(i));
    problem.SetManifold(parameters.Pose(i), new PoseManifold);
  }
}

// Equidistant lenses have no EXIF tag, so their intrinsics were measured.
bool MayRefine(const Camera& camera, const AdjustmentOptions& options) {
  return options.refine_exif_intrinsics && camera.source == CameraSource::kExif &&
         camera.distortion != DistortionModel::kEquidistant;
}

void AddLens(const Camera& camera,
             const AdjustmentOptions& options,
             Parameters& parameters,
             ceres::Problem& problem) {
  problem.AddParameterBlock(parameters.Lens(), kNumLensParameters);
  if (!MayRefine(camera, options)) {
    problem.SetParameterBlockConstant(parameters.Lens());
    return;
  }
  const double radial_sd = options.radial_sd, tangential_sd = options.tangential_sd;
  const double principal_sd = options.principal_point_sd_ratio;
  problem.AddResidualBlock(
      new ceres::AutoDiffCostFunction<LensPrior, kNumLensParameters, kNumLensParameters>(
          new LensPrior{{options.focal_sd_ratio,
                         radial_sd,
                         radial_sd,
                         tangential_sd,
                         tangential_sd,
                         principal_sd,
                         principal_sd}}),
      nullptr,
      parameters.Lens());
  if (static_cast<int>(parameters.num_views()) >= options.min_num_lens_views) return;
  problem.SetManifold(
      parameters.Lens(),
      new ceres::SubsetManifold(kNumLensParameters,
                                {kRadial2, kTangential1, kTangential2, kPrincipalX, kPrincipalY}));
}

// Readout time of a rolling shutter, seconds; 0 if all rows are exposed at once.
double ReadoutSeconds(const Camera& camera, const AdjustmentOptions& options) {
  return IsReadoutUnknown(camera) ? options.exif_readout_s : camera.readout_s;
}

// The powers from the second on allow the same turn at the first and at the last row.
ReadoutPrior ReadoutPriorFor(double readout_s, const AdjustmentOptions& options) {
  ReadoutPrior prior{};
  prior.sd[0] = readout_s * RadFromDeg(options.readout_rate_sd_deg_s);
  // A rate that changes by a per second adds a turn of a / 2 times the time squared.
  prior.sd[1] = 0.5 * readout_s * readout_s * RadFromDeg(options.readout_change_sd_deg_s2);
  for (size_t k = 2; k < Readout::kNumTurns; ++k) prior.sd[k] = 2.0 * prior.sd[k - 1];
  return prior;
}

void AddReadouts(double readout_s,
                 const SolverSettings& settings,
                 const AdjustmentOptions& options,
                 Parameters& parameters,
                 ceres::Problem& problem) {
  std::vector<int> fixed;
  for (int i = 3 * settings.num_turns; i < kNumReadoutParameters; ++i) fixed.push_back(i);
  for (size_t i = 0; i < parameters.num_views(); ++i) {
    problem.AddParameterBlock(parameters.ReadoutOf(i), kNumReadoutParameters);
    if (settings.num_turns == 0) {
      problem.SetParameterBlockConstant(parameters.ReadoutOf(i));
      continue;
    }
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<ReadoutPrior, kNumReadoutParameters, kNumReadoutParameters>(
            new ReadoutPrior(ReadoutPriorFor(readout_s, options))),
        nullptr,
        parameters.ReadoutOf(i));
    if (fixed.empty()) continue;
    problem.SetManifold(parameters.ReadoutOf(i),
                        new ceres::SubsetManifold(kNumReadoutParameters, fixed));
  }
}

// Returns the number of residuals.
int AddObservations(const Camera& camera,
                    double loss_px,
                    std::vector<BlockTrack>& tracks,
                    Parameters& parameters,
                    ceres::Problem& problem) {
  auto* loss = new ceres::CauchyLoss(loss_px);
  int num_residuals = 0;
  for (BlockTrack& track : tracks) {
    if (!track.has_point) continue;
    for (const Sighting& sighting : track.sightings) {
      if (!sighting.is_inlier) continue;
      problem.AddResidualBlock(new ReprojectionCost(&camera, sighting.point_in_image),
                               loss,
                               parameters.Pose(sighting.view),
                               track.point_in_world.data(),
                               parameters.Lens(),
                               parameters.ReadoutOf(sighting.view));
      num_residuals += 2;
    }
  }
  return num_residuals;
}

// Applies the change of the lens to the camera.
Camera Refined(const Camera& camera, const double* lens) {
  Camera refined = camera;
  refined.fx_px *= lens[kFocalFactor];
  refined.fy_px *= lens[kFocalFactor];
  refined.cx_px += camera.fx_px * lens[kPrincipalX];
  refined.cy_px += camera.fy_px * lens[kPrincipalY];
  const double* coefficients = lens + kRadial1;
  if (std::all_of(coefficients, coefficients + 4, [](double c) { return c == 0.0; })) {
    return refined;
  }
  refined.distortion = DistortionModel::kRadTan;
  refined.coefficients.resize(std::max<size_t>(4, refined.coefficients.size()), 0.0);
  for (size_t i = 0; i < 4; ++i) refined.coefficients[i] += coefficients[i];
  return refined;
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
    ordering->AddElementToGroup(parameters.Pose(i), 1);
    ordering->AddElementToGroup(parameters.ReadoutOf(i), 1);
  }
  ordering->AddElementToGroup(parameters.Lens(), 1);
  ceres::Solver::Options solver;
  solver.linear_solver_ordering = ordering;
  solver.linear_solver_type =
      parameters.num_views() <= kMaxNumDenseViews ? ceres::DENSE_SCHUR : ceres::SPARSE_SCHUR;
  solver.max_num_iterations = options.max_num_iterations;
  solver.function_tolerance = settings.function_tolerance;
  // More threads would change the order of sums, and with it the last digits, from run to run.
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

bool IsReadoutUnknown(const Camera& camera) {
  return camera.source == CameraSource::kExif && camera.readout_s == 0.0;
}

std::optional<SolvedBlock> SolveBlock(const std::vector<View>& views,
                                      const Camera& camera,
                                      const BlockState& start,
                                      const AdjustmentOptions& options,
                                      const SolverSettings& settings,
                                      std::vector<BlockTrack>& tracks) {
  Parameters parameters(start, camera);
  ceres::Problem problem;
  AddPriors(views, options, parameters, problem);
  AddLens(camera, options, parameters, problem);
  AddReadouts(ReadoutSeconds(camera, options), settings, options, parameters, problem);
  const int num_residuals = AddObservations(camera, settings.loss_px, tracks, parameters, problem);
  ceres::Solver::Summary summary;
  ceres::Solve(SolverOptions(options, settings, tracks, parameters), &problem, &summary);
  if (!summary.IsSolutionUsable() || !IsFinite(parameters, tracks)) return std::nullopt;
  if (parameters.Lens()[kFocalFactor] <= 0.0) return std::nullopt;
  SolvedBlock solved{
      {Refined(camera, parameters.Lens()), {}, {}}, summary.final_cost, num_residuals};
  for (size_t i = 0; i < views.size(); ++i) {
    solved.state.world_from_camera.push_back(
        {Eigen::Quaterniond(Eigen::Map<const Eigen::Vector4d>(parameters.Pose(i))).normalized(),
         Eigen::Map<const Eigen::Vector3d>(parameters.Pose(i) + 4)});
    solved.state.readouts.push_back(
        {Eigen::Map<const Eigen::Matrix<double, 3, Readout::kNumTurns>>(parameters.ReadoutOf(i))});
  }
  return solved;
}

}  // namespace freelsd
