#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <string>

#include <ceres/ceres.h>

#include "engine/adjustment/adjustment.h"
#include "engine/adjustment/landmarks.h"
#include "engine/adjustment/residuals.h"

namespace freelsd {
namespace {

// Landmarks with less parallax than this say nothing of height and are left out.
constexpr double kMinParallaxDeg = 1.0;
// An attitude found from matches alone: its yaw is hardly known, its tilt is that of a plane in
// level flight.
constexpr double kEstimatedYawSdDeg = 20.0;
constexpr double kEstimatedTiltSdDeg = 8.0;
// GPS may be off by more than it says; beyond this many deviations a position pulls less.
constexpr double kPositionLossSd = 2.5;
// Inliers that tie a view to the block.
constexpr int kMinNumInliers = 15;
// Poses start up to hundreds of pixels off: the first rounds forgive in multiples of the final
// outlier gate and of the final width of the loss.
struct Round {
  double gate_factor;
  double loss_factor;
};
constexpr std::array<Round, 4> kRounds{{{1e3, 30.0}, {10.0, 6.0}, {2.5, 2.0}, {1.0, 1.0}}};
// A start is poor where half of the sightings are farther off than this.
constexpr double kPoorStartPx = 20.0;
// A given attitude may be wronger than it says, as positions may.
constexpr double kAttitudeLossSd = 2.0;
// Pixel noise taken for the deviation of landmarks.
constexpr double kPixelSd = 0.7;
constexpr size_t kMinNumLandmarks = 20;

struct Parameters {
  std::vector<Eigen::Quaterniond> rotations;
  std::vector<Eigen::Vector3d> positions;
  std::array<double, 2> intrinsics{1.0, 0.0};
};

void AddPriors(const std::vector<View>& views,
               const AdjustmentOptions& options,
               Parameters& parameters,
               ceres::Problem& problem) {
  for (size_t i = 0; i < views.size(); ++i) {
    const View& view = views[i];
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<PositionPrior, 3, 3>(new PositionPrior{
                                 view.prior_position_in_world, std::max(view.position_sd_m, 0.01)}),
                             new ceres::HuberLoss(kPositionLossSd),
                             parameters.positions[i].data());
    const bool is_given = view.attitude_source == AttitudeSource::kGiven;
    const double tilt_sd_deg = is_given ? view.attitude_sd_deg : kEstimatedTiltSdDeg;
    const double yaw_sd_deg = is_given ? view.attitude_sd_deg : kEstimatedYawSdDeg;
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<AttitudePrior, 3, 4>(
                                 new AttitudePrior{view.world_from_camera.rotation,
                                                   RadFromDeg(std::max(tilt_sd_deg, 0.01)),
                                                   RadFromDeg(std::max(yaw_sd_deg, 0.01))}),
                             nullptr,
                             parameters.rotations[i].coeffs().data());
  }
  problem.AddResidualBlock(new ceres::AutoDiffCostFunction<IntrinsicsPrior, 2, 2>(
                               new IntrinsicsPrior{options.focal_sd_ratio, options.radial_sd}),
                           nullptr,
                           parameters.intrinsics.data());
}

void AddObservations(const Camera& camera,
                     double loss_px,
                     std::vector<BlockTrack>& tracks,
                     Parameters& parameters,
                     ceres::Problem& problem) {
  for (BlockTrack& track : tracks) {
    if (!track.has_point) continue;
    for (const Sighting& sighting : track.sightings) {
      if (!sighting.is_inlier) continue;
      problem.AddResidualBlock(new ceres::AutoDiffCostFunction<ReprojectionResidual, 2, 4, 3, 3, 2>(
                                   new ReprojectionResidual(&camera, sighting.point_in_image)),
                               new ceres::CauchyLoss(loss_px),
                               parameters.rotations[sighting.view].coeffs().data(),
                               parameters.positions[sighting.view].data(),
                               track.point_in_world.data(),
                               parameters.intrinsics.data());
    }
  }
}

// The camera with the refined factor and radial change applied.
Camera Refined(const Camera& camera, const std::array<double, 2>& intrinsics) {
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

bool MayRefine(const Camera& camera, const AdjustmentOptions& options) {
  return options.refine_exif_intrinsics && camera.source == CameraSource::kExif &&
         camera.distortion != DistortionModel::kEquidistant;
}

// One solve from the given state; nothing when the solver gave no usable answer.
std::optional<BlockState> Solve(const std::vector<View>& views,
                                const Camera& camera,
                                const BlockState& start,
                                const AdjustmentOptions& options,
                                double loss_px,
                                std::vector<BlockTrack>& tracks) {
  Parameters parameters;
  for (const Rigid3d& world_from_camera : start.world_from_camera) {
    parameters.rotations.push_back(world_from_camera.rotation);
    parameters.positions.push_back(world_from_camera.translation);
  }
  parameters.intrinsics[0] = start.camera.fx_px / camera.fx_px;
  if (!start.camera.coefficients.empty()) {
    parameters.intrinsics[1] =
        start.camera.coefficients[0] - (camera.coefficients.empty() ? 0.0 : camera.coefficients[0]);
  }
  ceres::Problem problem;
  AddPriors(views, options, parameters, problem);
  AddObservations(camera, loss_px, tracks, parameters, problem);
  for (Eigen::Quaterniond& rotation : parameters.rotations) {
    problem.SetManifold(rotation.coeffs().data(), new ceres::EigenQuaternionManifold);
  }
  if (!MayRefine(camera, options)) problem.SetParameterBlockConstant(parameters.intrinsics.data());
  ceres::Solver::Options solver;
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  for (BlockTrack& track : tracks) {
    if (track.has_point) ordering->AddElementToGroup(track.point_in_world.data(), 0);
  }
  for (size_t i = 0; i < views.size(); ++i) {
    ordering->AddElementToGroup(parameters.rotations[i].coeffs().data(), 1);
    ordering->AddElementToGroup(parameters.positions[i].data(), 1);
  }
  ordering->AddElementToGroup(parameters.intrinsics.data(), 1);
  solver.linear_solver_ordering = ordering;
  solver.linear_solver_type = ceres::SPARSE_SCHUR;
  solver.max_num_iterations = options.max_num_iterations;
  solver.num_threads = options.num_threads;
  solver.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  if (!summary.IsSolutionUsable()) return std::nullopt;
  BlockState solved{Refined(camera, parameters.intrinsics), {}};
  for (size_t i = 0; i < views.size(); ++i) {
    if (!parameters.positions[i].allFinite()) return std::nullopt;
    solved.world_from_camera.push_back(
        {parameters.rotations[i].normalized(), parameters.positions[i]});
  }
  return solved;
}

size_t NumPoints(const std::vector<BlockTrack>& tracks) {
  return static_cast<size_t>(std::count_if(
      tracks.begin(), tracks.end(), [](const BlockTrack& track) { return track.has_point; }));
}

// Poor attitudes first need landmarks that cannot be behind a camera: the ground plane's.
bool IsStartPoor(const BlockState& state, const std::vector<BlockTrack>& tracks) {
  std::vector<double> errors;
  for (const BlockTrack& track : tracks) {
    for (const Sighting& sighting : track.sightings) {
      const std::optional<double> error =
          track.has_point ? ReprojectionError(state, track, sighting) : std::nullopt;
      errors.push_back(error.value_or(std::numeric_limits<double>::infinity()));
    }
  }
  if (errors.empty()) return true;
  std::nth_element(errors.begin(),
                   errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2),
                   errors.end());
  return errors[errors.size() / 2] > kPoorStartPx;
}

// Rounds of solving with ever tighter gates. Empty when the block does not hold together.
std::optional<BlockState> SolveInRounds(const std::vector<View>& views,
                                        const BlockState& start,
                                        const AdjustmentOptions& options,
                                        std::vector<BlockTrack>& tracks) {
  BlockState state = start;
  const bool is_start_poor = IsStartPoor(start, tracks);
  for (size_t round = is_start_poor ? 0 : 1; round < kRounds.size(); ++round) {
    const double gate_px = kRounds[round].gate_factor * options.max_reprojection_error_px;
    if (round == 0) {
      InitialiseOnGround(views, state, tracks);
    } else {
      TriangulateTracks(state, kMinParallaxDeg, tracks);
    }
    MarkOutliers(state, gate_px, tracks);
    if (NumPoints(tracks) < kMinNumLandmarks) return std::nullopt;
    const double loss_px = kRounds[round].loss_factor * options.robust_loss_px;
    const std::optional<BlockState> solved =
        Solve(views, start.camera, state, options, loss_px, tracks);
    if (!solved) return std::nullopt;
    state = *solved;
    // What was an outlier for poor poses may fit the better ones.
    MarkOutliers(state, gate_px, tracks);
  }
  return state;
}

std::vector<int> InliersPerView(size_t num_views, const std::vector<BlockTrack>& tracks) {
  std::vector<int> counts(num_views, 0);
  for (const BlockTrack& track : tracks) {
    if (!track.has_point) continue;
    for (const Sighting& sighting : track.sightings) {
      if (sighting.is_inlier) ++counts[sighting.view];
    }
  }
  return counts;
}

double MedianDepth(const BlockState& state,
                   size_t view,
                   const std::vector<size_t>& landmark_indices,
                   const std::vector<Landmark>& landmarks) {
  std::vector<double> heights;
  for (const size_t index : landmark_indices) {
    heights.push_back(state.world_from_camera[view].translation.z() -
                      landmarks[index].point_in_world.z());
  }
  std::nth_element(heights.begin(), heights.begin() + heights.size() / 2, heights.end());
  return heights[heights.size() / 2];
}

void FillResult(const std::vector<View>& views,
                const BlockState& state,
                const std::vector<BlockTrack>& tracks,
                AdjustedBlock& block) {
  const std::vector<int> inliers = InliersPerView(views.size(), tracks);
  for (size_t i = 0; i < views.size(); ++i) {
    block.views[i].world_from_camera = state.world_from_camera[i];
    block.views[i].is_connected = inliers[i] >= kMinNumInliers;
  }
  for (const BlockTrack& track : tracks) {
    if (!track.has_point) continue;
    for (const Sighting& sighting : track.sightings) {
      if (sighting.is_inlier)
        block.views[sighting.view].landmarks.push_back(block.landmarks.size());
    }
    block.landmarks.push_back(
        {track.point_in_world, HeightDeviation(state, track, kPixelSd), track.NumInliers()});
  }
  for (size_t i = 0; i < views.size(); ++i) {
    AdjustedView& view = block.views[i];
    // Rays of a view average its own position noise over its height: a coarse bound.
    view.position_sd_m = view.is_connected ? views[i].height_above_ground * kPixelSd /
                                                 state.camera.MeanFocalPx() * std::sqrt(2.0)
                                           : views[i].position_sd_m;
    if (view.landmarks.empty()) continue;
    view.height_above_ground = MedianDepth(state, i, view.landmarks, block.landmarks);
  }
}

void Require(bool holds, const char* field, double value, const char* constraint) {
  if (holds) return;
  throw std::invalid_argument(std::string("adjustment.") + field + " = " + std::to_string(value) +
                              ": " + constraint);
}

}  // namespace

void AdjustmentOptions::Check() const {
  Require(min_num_track_connections >= 1,
          "min_num_track_connections",
          min_num_track_connections,
          "must be >= 1");
  Require(min_baseline_m > 0.0, "min_baseline_m", min_baseline_m, "must be positive");
  Require(max_baseline_ratio > 0.0 && max_baseline_ratio <= 2.0,
          "max_baseline_ratio",
          max_baseline_ratio,
          "must be in (0, 2]");
  Require(robust_loss_px > 0.0, "robust_loss_px", robust_loss_px, "must be positive");
  Require(max_reprojection_error_px > 0.0,
          "max_reprojection_error_px",
          max_reprojection_error_px,
          "must be positive");
  Require(focal_sd_ratio > 0.0 && focal_sd_ratio <= 0.5,
          "focal_sd_ratio",
          focal_sd_ratio,
          "must be in (0, 0.5]");
  Require(radial_sd > 0.0, "radial_sd", radial_sd, "must be positive");
  Require(max_num_iterations >= 1 && max_num_iterations <= 1000,
          "max_num_iterations",
          max_num_iterations,
          "must be in [1, 1000]");
  Require(num_threads >= 1 && num_threads <= 64, "num_threads", num_threads, "must be in [1, 64]");
}

AdjustedBlock AdjustPoses(const std::vector<View>& views,
                          const Camera& camera,
                          const AdjustmentOptions& options) {
  if (views.empty()) throw std::invalid_argument("adjustment: no views were given");
  AdjustedBlock block;
  block.camera = camera;
  BlockState start{camera, {}};
  for (const View& view : views) {
    start.world_from_camera.push_back(view.world_from_camera);
    block.views.push_back({view.frame_id,
                           view.world_from_camera,
                           view.height_above_ground,
                           false,
                           view.position_sd_m,
                           {}});
  }
  std::vector<BlockTrack> tracks = CollectTracks(views);
  TriangulateTracks(start, kMinParallaxDeg, tracks);
  block.rms_before_px = RmsError(start, tracks);
  const std::optional<BlockState> state = SolveInRounds(views, start, options, tracks);
  if (!state) {
    block.note = "fewer than " + std::to_string(kMinNumLandmarks) +
                 " landmarks are seen with enough parallax: poses are not adjusted";
    return block;
  }
  block.camera = state->camera;
  block.rms_after_px = RmsError(*state, tracks);
  FillResult(views, *state, tracks, block);
  const auto num_connected = std::count_if(
      block.views.begin(), block.views.end(), [](const auto& view) { return view.is_connected; });
  block.is_usable = num_connected >= 2;
  if (!block.is_usable) block.note = "no two views are tied together by enough landmarks";
  return block;
}

}  // namespace freelsd
