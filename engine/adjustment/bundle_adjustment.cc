#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>

#include "engine/adjustment/adjustment.h"
#include "engine/adjustment/evidence.h"
#include "engine/adjustment/landmarks.h"
#include "engine/adjustment/solver.h"
#include "engine/adjustment/verdict.h"
#include "engine/check/check.h"

namespace freelsd {
namespace {

// Landmarks with less parallax do not determine heights and are left out.
constexpr double kMinParallaxDeg = 1.0;
// Poses may start hundreds of pixels off. The first rounds use multiples of the final outlier gate
// and of the final loss width.
struct Round {
  double gate_factor;
  double loss_factor;
  // That of the last round is AdjustmentOptions::function_tolerance.
  double function_tolerance;
};
constexpr std::array<Round, 4> kRounds{
    {{1e3, 30.0, 1e-2}, {10.0, 6.0, 1e-2}, {2.5, 2.0, 1e-3}, {1.0, 1.0, 0.0}}};
// A start is poor if, in some view, half of the sightings have a larger error: the gate of the
// second round would drop that view for good.
constexpr double kPoorStartPx = 40.0;
// Early rounds are skipped if, in every view, the error of half of the sightings is at most this
// multiple of robust_loss_px.
constexpr double kGoodStartFactor = 1.0;
// Assumed pixel noise for the deviation of landmarks.
constexpr double kPixelSd = 0.7;
constexpr size_t kMinNumLandmarks = 20;
// A block without noise has no outliers of a fraction of a pixel.
constexpr double kMinGatePx = 1.0;

size_t NumPoints(const std::vector<BlockTrack>& tracks) {
  return static_cast<size_t>(std::count_if(
      tracks.begin(), tracks.end(), [](const BlockTrack& track) { return track.has_point; }));
}

struct RoundsResult {
  BlockState state;
  std::vector<ParameterEvidence> evidence;
};

// The last round: chooses the motion during readout. Better motion brings back sightings that the
// first solution of this round had dropped, so a richer one is solved once more.
std::optional<RoundsResult> SolveLastRound(const std::vector<View>& views,
                                           const Camera& camera,
                                           ChosenBlock first,
                                           const AdjustmentOptions& options,
                                           std::vector<BlockTrack>& tracks) {
  const int num_first_turns = first.settings.num_turns;
  ChosenBlock chosen = ChooseReadout(views, camera, options, std::move(first));
  tracks = std::move(chosen.tracks);
  RoundsResult result{chosen.solved.state, chosen.evidence};
  if (chosen.settings.num_turns <= num_first_turns) return result;
  TriangulateTracks(result.state, kMinParallaxDeg, options.max_reprojection_error_px, tracks);
  const std::optional<SolvedBlock> solved =
      SolveBlock(views, camera, result.state, options, chosen.settings, tracks);
  if (!solved) return std::nullopt;
  result.state = solved->state;
  return result;
}

// Solves in rounds, each with a narrower outlier gate than the last. Skips wide gates that the
// start does not need. Empty if a round finds no solution.
std::optional<RoundsResult> SolveInRounds(const std::vector<View>& views,
                                          const BlockState& start,
                                          const AdjustmentOptions& options,
                                          std::vector<BlockTrack>& tracks) {
  std::optional<RoundsResult> result = RoundsResult{start, {}};
  for (const Round& round : kRounds) {
    const BlockState& state = result->state;
    const double gate_px = round.gate_factor * options.max_reprojection_error_px;
    const bool is_first = &round == &kRounds.front();
    const bool is_last = &round == &kRounds.back();
    if (!is_first) TriangulateTracks(state, kMinParallaxDeg, gate_px, tracks);
    const double median_px = WorstMedianError(state, tracks);
    if (is_first) {
      if (median_px <= kPoorStartPx) continue;
      // The rays of poor poses do not meet. Points on the ground plane are never behind a camera.
      InitialiseOnGround(views, state, tracks);
      MarkOutliers(state, gate_px, tracks);
    } else if (!is_last && median_px <= kGoodStartFactor * options.robust_loss_px) {
      continue;
    }
    if (NumPoints(tracks) < kMinNumLandmarks) return std::nullopt;
    const double tolerance = is_last ? options.function_tolerance : round.function_tolerance;
    const SolverSettings settings = WithFirstTurns(
        {round.loss_factor * options.robust_loss_px, tolerance}, start.camera, options);
    const std::optional<SolvedBlock> solved =
        SolveBlock(views, start.camera, Restricted(state, settings), options, settings, tracks);
    if (!solved) return std::nullopt;
    result = is_last ? SolveLastRound(
                           views, start.camera, {*solved, settings, tracks, {}}, options, tracks)
                     : RoundsResult{solved->state, {}};
    if (!result) return std::nullopt;
  }
  // Errors of both axes together have the median sqrt(2 ln 2) = 1.18 deviations of one axis.
  const double sd_px = MedianError(result->state, tracks) / std::sqrt(2.0 * std::log(2.0));
  MarkOutliers(result->state,
               std::min(options.max_reprojection_error_px,
                        std::max(options.max_reprojection_error_sigma * sd_px, kMinGatePx)),
               tracks);
  return result;
}

double MedianDepth(const BlockState& state,
                   size_t view,
                   const std::vector<size_t>& landmark_indices,
                   const std::vector<Landmark>& landmarks) {
  std::vector<double> heights;
  heights.reserve(landmark_indices.size());
  for (const size_t index : landmark_indices) {
    heights.push_back(state.world_from_camera[view].translation.z() -
                      landmarks[index].point_in_world.z());
  }
  std::nth_element(heights.begin(), heights.begin() + heights.size() / 2, heights.end());
  return heights[heights.size() / 2];
}

void FillLandmarks(const BlockState& state,
                   const std::vector<BlockTrack>& tracks,
                   AdjustedBlock& block) {
  for (const BlockTrack& track : tracks) {
    if (!track.has_point) continue;
    const auto is_seen = [&](const Sighting& sighting) {
      return sighting.is_inlier && block.views[sighting.view].is_connected;
    };
    // Views outside the block do not count for its landmarks.
    const auto num_views = std::count_if(track.sightings.begin(), track.sightings.end(), is_seen);
    if (num_views < 2) continue;
    for (const Sighting& sighting : track.sightings) {
      if (is_seen(sighting)) block.views[sighting.view].landmarks.push_back(block.landmarks.size());
    }
    block.landmarks.push_back({track.point_in_world,
                               HeightDeviation(state, track, kPixelSd),
                               static_cast<int>(num_views),
                               track.id});
  }
}

AdjustedBlock PriorBlock(const std::vector<View>& views, const Camera& camera) {
  AdjustedBlock block;
  block.camera = camera;
  for (const View& view : views) {
    block.views.push_back({view.frame_id,
                           view.world_from_camera,
                           view.readout,
                           view.height_above_ground,
                           false,
                           -1,
                           view.position_sd_m,
                           {}});
  }
  return block;
}

// All groups share one map, so the worst group limits its accuracy.
double LargestPositionDeviation(const std::vector<AdjustedView>& views) {
  double largest_m = 0.0;
  for (const AdjustedView& view : views) {
    if (view.is_connected) largest_m = std::max(largest_m, view.position_sd_m);
  }
  return largest_m;
}

// Copies the solved block. Poses of views outside it stay the priors.
void FillResult(const BlockState& state,
                const std::vector<BlockTrack>& tracks,
                const BlockVerdict& verdict,
                AdjustedBlock& block) {
  block.camera = state.camera;
  block.tilt_sd_deg = verdict.tilt_sd_deg;
  for (size_t i = 0; i < block.views.size(); ++i) {
    if (!verdict.is_connected[i]) continue;
    block.views[i].world_from_camera = state.world_from_camera[i];
    block.views[i].readout = state.readouts[i];
    block.views[i].is_connected = true;
    block.views[i].group = verdict.group[i];
    block.views[i].position_sd_m = verdict.position_sd_m[i];
  }
  block.position_sd_m = LargestPositionDeviation(block.views);
  FillLandmarks(state, tracks, block);
  for (size_t i = 0; i < block.views.size(); ++i) {
    AdjustedView& view = block.views[i];
    if (view.landmarks.empty()) continue;
    view.height_above_ground = MedianDepth(state, i, view.landmarks, block.landmarks);
  }
}

void CheckLensAndReadout(const AdjustmentOptions& options, const FieldCheck& check) {
  check.Require(options.focal_sd_ratio > 0.0 && options.focal_sd_ratio <= 0.5,
                "focal_sd_ratio",
                options.focal_sd_ratio,
                "must be in (0, 0.5]");
  check.Require(options.radial_sd > 0.0, "radial_sd", options.radial_sd, "must be positive");
  check.Require(
      options.tangential_sd > 0.0, "tangential_sd", options.tangential_sd, "must be positive");
  check.Require(options.principal_point_sd_ratio > 0.0 && options.principal_point_sd_ratio <= 0.5,
                "principal_point_sd_ratio",
                options.principal_point_sd_ratio,
                "must be in (0, 0.5]");
  check.Require(options.min_num_lens_views >= 1,
                "min_num_lens_views",
                options.min_num_lens_views,
                "must be >= 1");
  check.Require(options.readout_rate_sd_deg_s > 0.0 && options.readout_rate_sd_deg_s <= 360.0,
                "readout_rate_sd_deg_s",
                options.readout_rate_sd_deg_s,
                "must be in (0, 360]");
  check.Require(
      options.readout_change_sd_deg_s2 > 0.0 && options.readout_change_sd_deg_s2 <= 10000.0,
      "readout_change_sd_deg_s2",
      options.readout_change_sd_deg_s2,
      "must be in (0, 10000]");
  check.Inside("max_readout_power", options.max_readout_power, 1, Readout::kNumTurns);
  check.Inside("exif_readout_s", options.exif_readout_s, 0.0, 1.0);
}

}  // namespace

void AdjustmentOptions::Check() const {
  const FieldCheck check("adjustment");
  check.Require(min_num_track_connections >= 1,
                "min_num_track_connections",
                min_num_track_connections,
                "must be >= 1");
  check.Require(min_baseline_m > 0.0, "min_baseline_m", min_baseline_m, "must be positive");
  check.Require(max_baseline_ratio > 0.0 && max_baseline_ratio <= 2.0,
                "max_baseline_ratio",
                max_baseline_ratio,
                "must be in (0, 2]");
  check.Require(robust_loss_px > 0.0, "robust_loss_px", robust_loss_px, "must be positive");
  check.Require(max_reprojection_error_px > 0.0,
                "max_reprojection_error_px",
                max_reprojection_error_px,
                "must be positive");
  check.Require(max_reprojection_error_sigma >= 3.0,
                "max_reprojection_error_sigma",
                max_reprojection_error_sigma,
                "must be >= 3");
  CheckLensAndReadout(*this, check);
  check.Inside("max_num_iterations", max_num_iterations, 1, 1000);
  check.Require(function_tolerance > 0.0 && function_tolerance < 1.0,
                "function_tolerance",
                function_tolerance,
                "must be in (0, 1)");
  check.Inside("num_refinement_tracks", num_refinement_tracks, 0, 100000);
  check.Require(estimated_tilt_sd_deg > 0.0 && estimated_tilt_sd_deg <= 90.0,
                "estimated_tilt_sd_deg",
                estimated_tilt_sd_deg,
                "must be in (0, 90]");
  check.Require(estimated_yaw_sd_deg > 0.0 && estimated_yaw_sd_deg <= 180.0,
                "estimated_yaw_sd_deg",
                estimated_yaw_sd_deg,
                "must be in (0, 180]");
  check.Require(min_num_view_observations >= 3,
                "min_num_view_observations",
                min_num_view_observations,
                "must be >= 3");
  check.Require(min_num_shared_landmarks >= 1,
                "min_num_shared_landmarks",
                min_num_shared_landmarks,
                "must be >= 1");
  check.Require(min_num_connected_views >= 2,
                "min_num_connected_views",
                min_num_connected_views,
                "must be >= 2");
  check.Require(min_position_spread_sigma >= 0.0,
                "min_position_spread_sigma",
                min_position_spread_sigma,
                "must be >= 0");
  check.Require(max_tilt_sd_deg > 0.0 && max_tilt_sd_deg <= 90.0,
                "max_tilt_sd_deg",
                max_tilt_sd_deg,
                "must be in (0, 90]");
  check.Inside("num_threads", num_threads, 1, 64);
}

std::vector<size_t> AdjustedBlock::LargestGroup() const {
  std::map<int, std::vector<size_t>> groups;
  std::vector<size_t> largest;
  for (size_t i = 0; i < views.size(); ++i) {
    if (!views[i].is_connected) continue;
    std::vector<size_t>& group = groups[views[i].group];
    group.push_back(i);
    if (group.size() > largest.size()) largest = group;
  }
  return largest;
}

AdjustedBlock AdjustPoses(const std::vector<View>& views,
                          const Camera& camera,
                          const AdjustmentOptions& options) {
  if (views.empty()) throw std::invalid_argument("adjustment: no views were given");
  AdjustedBlock block = PriorBlock(views, camera);
  BlockState start{camera, {}, {}};
  for (const View& view : views) {
    start.world_from_camera.push_back(view.world_from_camera);
    start.readouts.push_back(view.readout);
  }
  std::vector<BlockTrack> tracks = CollectTracks(views);
  TriangulateTracks(
      start, kMinParallaxDeg, kRounds[0].gate_factor * options.max_reprojection_error_px, tracks);
  block.rms_before_px = RmsError(start, tracks);
  const std::optional<RoundsResult> result = SolveInRounds(views, start, options, tracks);
  if (!result) {
    block.note = "fewer than " + std::to_string(kMinNumLandmarks) +
                 " landmarks are seen with enough parallax: poses are not adjusted";
    return block;
  }
  const BlockState& state = result->state;
  const BlockVerdict verdict = JudgeBlock(views, state, tracks, options);
  block.evidence = result->evidence;
  block.note = verdict.note;
  block.rms_after_px = RmsError(state, tracks);
  block.is_usable = std::find(verdict.is_connected.begin(), verdict.is_connected.end(), true) !=
                    verdict.is_connected.end();
  if (block.is_usable) {
    FillResult(state, tracks, verdict, block);
  } else if (block.note.empty()) {
    block.note = "fewer than " + std::to_string(options.min_num_connected_views) +
                 " views are tied together by enough landmarks";
  }
  return block;
}

}  // namespace freelsd
