#include "engine/adjustment/landmarks.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

namespace freelsd {
namespace {

std::vector<PosedRay> Rays(const BlockState& state, const BlockTrack& track) {
  std::vector<PosedRay> rays;
  for (const Sighting& sighting : track.sightings) {
    if (!sighting.is_inlier) continue;
    rays.push_back({state.world_from_camera[sighting.view],
                    state.camera.NormalizedFromImage(sighting.point_in_image)});
  }
  return rays;
}

// Mean over the sightings of where their rays meet the ground below their own view.
std::optional<Eigen::Vector3d> OnGround(const std::vector<View>& views,
                                        const BlockState& state,
                                        const BlockTrack& track) {
  // Rays flatter than this hit the plane too far away to be of use.
  constexpr double kMinDescent = 0.2;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int count = 0;
  for (const Sighting& sighting : track.sightings) {
    const Rigid3d& world_from_camera = state.world_from_camera[sighting.view];
    const Eigen::Vector3d ray =
        world_from_camera.rotation * state.camera.RayFromImage(sighting.point_in_image);
    if (ray.z() > -kMinDescent) continue;
    sum +=
        world_from_camera.translation + ray * (views[sighting.view].height_above_ground / -ray.z());
    ++count;
  }
  if (count == 0) return std::nullopt;
  return sum / count;
}

}  // namespace

int BlockTrack::NumInliers() const {
  return static_cast<int>(std::count_if(
      sightings.begin(), sightings.end(), [](const Sighting& s) { return s.is_inlier; }));
}

std::vector<BlockTrack> CollectTracks(const std::vector<View>& views) {
  std::map<int64_t, BlockTrack> by_id;
  for (size_t i = 0; i < views.size(); ++i) {
    for (const Observation& observation : views[i].observations) {
      by_id[observation.track_id].sightings.push_back({i, observation.point_in_image});
    }
  }
  std::vector<BlockTrack> tracks;
  for (auto& [id, track] : by_id) {
    if (track.sightings.size() >= 2) tracks.push_back(std::move(track));
  }
  return tracks;
}

void InitialiseOnGround(const std::vector<View>& views,
                        const BlockState& state,
                        std::vector<BlockTrack>& tracks) {
  for (BlockTrack& track : tracks) {
    const std::optional<Eigen::Vector3d> point = OnGround(views, state, track);
    track.has_point = point.has_value();
    if (point) track.point_in_world = *point;
  }
}

void TriangulateTracks(const BlockState& state,
                       double min_parallax_deg,
                       std::vector<BlockTrack>& tracks) {
  for (BlockTrack& track : tracks) {
    const std::optional<TriangulatedPoint> point = Triangulate(Rays(state, track));
    track.has_point = point && DegFromRad(point->parallax) >= min_parallax_deg;
    if (track.has_point) track.point_in_world = point->point_in_world;
  }
}

std::optional<double> ReprojectionError(const BlockState& state,
                                        const BlockTrack& track,
                                        const Sighting& sighting) {
  const Eigen::Vector3d point_in_camera =
      Inverse(state.world_from_camera[sighting.view]) * track.point_in_world;
  const std::optional<Eigen::Vector2d> projection = state.camera.ImageFromCamera(point_in_camera);
  if (!projection) return std::nullopt;
  return (*projection - sighting.point_in_image).norm();
}

void MarkOutliers(const BlockState& state, double max_error_px, std::vector<BlockTrack>& tracks) {
  for (BlockTrack& track : tracks) {
    if (!track.has_point) continue;
    for (Sighting& sighting : track.sightings) {
      const std::optional<double> error = ReprojectionError(state, track, sighting);
      sighting.is_inlier = error && *error <= max_error_px;
    }
    if (track.NumInliers() < 2) track.has_point = false;
  }
}

double RmsError(const BlockState& state, const std::vector<BlockTrack>& tracks) {
  double sum = 0.0;
  int count = 0;
  for (const BlockTrack& track : tracks) {
    if (!track.has_point) continue;
    for (const Sighting& sighting : track.sightings) {
      const std::optional<double> error = ReprojectionError(state, track, sighting);
      if (!sighting.is_inlier || !error) continue;
      sum += *error * *error;
      ++count;
    }
  }
  return count > 0 ? std::sqrt(sum / count) : 0.0;
}

double HeightDeviation(const BlockState& state, const BlockTrack& track, double pixel_sd) {
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  for (const Sighting& sighting : track.sightings) {
    if (!sighting.is_inlier) continue;
    const Eigen::Vector3d to_point =
        track.point_in_world - state.world_from_camera[sighting.view].translation;
    const double distance = to_point.norm();
    const Eigen::Vector3d ray = to_point / distance;
    const double across_sd = pixel_sd * distance / state.camera.MeanFocalPx();
    information += (Eigen::Matrix3d::Identity() - ray * ray.transpose()) / (across_sd * across_sd);
  }
  return std::sqrt(std::max(0.0, information.inverse()(2, 2)));
}

}  // namespace freelsd
