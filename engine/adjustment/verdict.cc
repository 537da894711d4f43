#include "engine/adjustment/verdict.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <optional>

#include <Eigen/Dense>

#include "engine/adjustment/solver.h"

namespace freelsd {
namespace {

// Least assumed pixel noise, even if the residuals are smaller.
constexpr double kMinPixelSd = 0.7;
// GPS errors drift over minutes: any number of views has at most this many independent fixes.
constexpr double kNumIndependentFixes = 4.0;
// An error common to all fixes moves the block and stays invisible. An error that drifts over 30 s
// leaves, in flights of two minutes, half as much variance in the mean as about it.
constexpr double kNumIndependentShown = 2.0;

using Group = std::vector<size_t>;  // views, ascending
// Tracks that each view sees well, ascending.
using TracksOfViews = std::vector<std::vector<size_t>>;

TracksOfViews InlierTracks(size_t num_views, const std::vector<BlockTrack>& tracks) {
  TracksOfViews seen(num_views);
  for (size_t i = 0; i < tracks.size(); ++i) {
    if (!tracks[i].has_point) continue;
    for (const Sighting& sighting : tracks[i].sightings) {
      if (sighting.is_inlier) seen[sighting.view].push_back(i);
    }
  }
  return seen;
}

int NumShared(const std::vector<size_t>& a, const std::vector<size_t>& b) {
  int num_shared = 0;
  for (size_t i = 0, j = 0; i < a.size() && j < b.size();) {
    num_shared += a[i] == b[j] ? 1 : 0;
    const size_t smaller = std::min(a[i], b[j]);
    if (a[i] == smaller) ++i;
    if (j < b.size() && b[j] == smaller) ++j;
  }
  return num_shared;
}

// Views connected through neighbours that share enough landmarks.
std::vector<Group> Groups(const TracksOfViews& seen, const AdjustmentOptions& options) {
  std::vector<Group> groups;
  std::vector<bool> is_taken(seen.size(), false);
  for (size_t first = 0; first < seen.size(); ++first) {
    if (is_taken[first]) continue;
    is_taken[first] = true;
    Group group{first};
    for (size_t next = 0; next < group.size(); ++next) {
      for (size_t view = 0; view < seen.size(); ++view) {
        if (is_taken[view] ||
            NumShared(seen[group[next]], seen[view]) < options.min_num_shared_landmarks) {
          continue;
        }
        is_taken[view] = true;
        group.push_back(view);
      }
    }
    std::sort(group.begin(), group.end());
    groups.push_back(std::move(group));
  }
  return groups;
}

// Repeatedly removes views with too few sightings of tracks that others of the group see, until all
// have enough.
Group WithoutLooseViews(Group group, const TracksOfViews& seen, int min_num_observations) {
  while (true) {
    std::vector<int> num_views(0);
    for (const size_t view : group) {
      for (const size_t track : seen[view]) {
        num_views.resize(std::max(num_views.size(), track + 1), 0);
        ++num_views[track];
      }
    }
    const auto is_loose = [&](size_t view) {
      return std::count_if(seen[view].begin(), seen[view].end(), [&](size_t track) {
               return num_views[track] >= 2;
             }) < min_num_observations;
    };
    const auto end = std::remove_if(group.begin(), group.end(), is_loose);
    if (end == group.end()) return group;
    group.erase(end, group.end());
  }
}

// Per axis; means over the views.
struct PositionVariance {
  double claimed = 0.0;  // by the priors themselves
  double shown = 0.0;    // by the solved block, relative to their common error

  // Variance of one view's position relative to the others. A geotag that lags the shutter by a
  // second is 13 m off, whatever deviation its GPS states.
  double OfOne() const { return std::max(claimed, shown); }
  // Variance of the mean position of all views.
  double OfMean(size_t num_views) const {
    const auto num = static_cast<double>(num_views);
    return std::max(claimed / std::min(kNumIndependentFixes, num),
                    shown / std::min(kNumIndependentShown, num));
  }
};

PositionVariance VarianceOfPositions(const std::vector<View>& views,
                                     const BlockState& state,
                                     const Group& group) {
  PositionVariance variance;
  for (const size_t view : group) {
    const Eigen::Vector3d residual =
        state.world_from_camera[view].translation - views[view].prior_position_in_world;
    variance.claimed += std::pow(views[view].position_sd_m, 2);
    variance.shown += residual.squaredNorm() / 3.0;
  }
  variance.claimed /= static_cast<double>(group.size());
  variance.shown /= static_cast<double>(group.size());
  return variance;
}

Eigen::Vector3d MeanPosition(const BlockState& state, const Group& group) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const size_t view : group) mean += state.world_from_camera[view].translation;
  return mean / static_cast<double>(group.size());
}

// Root mean square distance of the positions from their mean, in deviations of their priors.
double PositionSpread(const std::vector<View>& views, const BlockState& state, const Group& group) {
  const Eigen::Vector3d mean = MeanPosition(state, group);
  double sum = 0.0;
  for (const size_t view : group) {
    sum += (state.world_from_camera[view].translation - mean).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(group.size()) /
                   VarianceOfPositions(views, state, group).OfOne());
}

// Tilt of the whole group about its worse horizontal axis. Positions constrain it by their lever
// arms. Attitudes share the error of the mount, so all of them count as one.
double TiltDeviation(const std::vector<View>& views,
                     const BlockState& state,
                     const Group& group,
                     const AdjustmentOptions& options) {
  const Eigen::Vector3d mean = MeanPosition(state, group);
  const double variance = VarianceOfPositions(views, state, group).OfOne();
  Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
  double attitude_information = 0.0;
  for (const size_t view : group) {
    const Eigen::Vector3d arm = state.world_from_camera[view].translation - mean;
    information += (arm.squaredNorm() * Eigen::Matrix2d::Identity() -
                    arm.head<2>() * arm.head<2>().transpose()) /
                   variance;
    attitude_information += std::pow(AttitudeDeviationOf(views[view], options).tilt_sd, -2);
  }
  information +=
      attitude_information / static_cast<double>(group.size()) * Eigen::Matrix2d::Identity();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(information);
  return 1.0 / std::sqrt(eigen.eigenvalues()[0]);
}

// Reason why the group is not accurate enough for a map; empty if it is.
std::string Objection(double spread_sigma, double tilt_sd_deg, const AdjustmentOptions& options) {
  char text[160];
  if (spread_sigma < options.min_position_spread_sigma) {
    std::snprintf(text,
                  sizeof(text),
                  "positions spread only %.1f times their deviation: a hover, or a GPS too coarse "
                  "for it, gives no scale",
                  spread_sigma);
    return text;
  }
  if (tilt_sd_deg > options.max_tilt_sd_deg) {
    std::snprintf(text,
                  sizeof(text),
                  "the tilt of the ground is known to %.1f deg only: views in one line need "
                  "attitudes, or a second line beside them",
                  tilt_sd_deg);
    return text;
  }
  return {};
}

// Variance of one view's position with the landmarks held fixed, mean of the three axes.
double OwnVariance(const BlockState& state,
                   size_t view,
                   const std::vector<size_t>& seen,
                   const std::vector<BlockTrack>& tracks,
                   double pixel_sd) {
  const Rigid3d& world_from_camera = state.world_from_camera[view];
  const Eigen::Matrix3d camera_from_world =
      world_from_camera.rotation.conjugate().toRotationMatrix();
  Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Zero();
  for (const size_t track : seen) {
    const Eigen::Vector3d arm = tracks[track].point_in_world - world_from_camera.translation;
    const Eigen::Vector3d x = camera_from_world * arm;
    Eigen::Matrix<double, 2, 3> projection;
    projection << 1.0, 0.0, -x.x() / x.z(), 0.0, 1.0, -x.y() / x.z();
    projection *= state.camera.MeanFocalPx() / (x.z() * pixel_sd);
    Eigen::Matrix3d cross;
    cross << 0.0, -arm.z(), arm.y(), arm.z(), 0.0, -arm.x(), -arm.y(), arm.x(), 0.0;
    Eigen::Matrix<double, 2, 6> jacobian;
    jacobian << -projection * camera_from_world, projection * camera_from_world * cross;
    information += jacobian.transpose() * jacobian;
  }
  const Eigen::Matrix<double, 6, 6> covariance =
      information.ldlt().solve(Eigen::Matrix<double, 6, 6>::Identity());
  return covariance.topLeftCorner<3, 3>().trace() / 3.0;
}

}  // namespace

BlockVerdict JudgeBlock(const std::vector<View>& views,
                        const BlockState& state,
                        const std::vector<BlockTrack>& tracks,
                        const AdjustmentOptions& options) {
  BlockVerdict verdict;
  verdict.is_connected.assign(views.size(), false);
  verdict.group.assign(views.size(), -1);
  int num_groups = 0;
  for (const View& view : views) verdict.position_sd_m.push_back(view.position_sd_m);
  const TracksOfViews seen = InlierTracks(views.size(), tracks);
  const double pixel_sd = std::max(kMinPixelSd, RmsError(state, tracks) / std::sqrt(2.0));
  for (const Group& tied : Groups(seen, options)) {
    const Group group = WithoutLooseViews(tied, seen, options.min_num_view_observations);
    if (static_cast<int>(group.size()) < options.min_num_connected_views) continue;
    const double tilt_sd_deg = DegFromRad(TiltDeviation(views, state, group, options));
    const std::string objection =
        Objection(PositionSpread(views, state, group), tilt_sd_deg, options);
    if (!objection.empty()) {
      verdict.note = objection;
      continue;
    }
    verdict.tilt_sd_deg = std::max(verdict.tilt_sd_deg, tilt_sd_deg);
    const double common_variance = VarianceOfPositions(views, state, group).OfMean(group.size());
    for (const size_t view : group) {
      verdict.is_connected[view] = true;
      verdict.group[view] = num_groups;
      verdict.position_sd_m[view] =
          std::sqrt(common_variance + OwnVariance(state, view, seen[view], tracks, pixel_sd));
    }
    ++num_groups;
  }
  return verdict;
}

}  // namespace freelsd
