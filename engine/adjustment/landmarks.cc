#include "engine/adjustment/landmarks.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include <Eigen/Dense>

namespace freelsd {
namespace {

double NormalizedError(const PosedRay& ray, const Eigen::Vector3d& point_in_world) {
  const Eigen::Vector3d x = Inverse(ray.world_from_camera) * point_in_world;
  if (x.z() <= 0.0) return std::numeric_limits<double>::infinity();
  return (x.hnormalized() - ray.point_normalized).norm();
}

// Point where rays meet, and the rays that do.
struct Meeting {
  TriangulatedPoint point;
  std::vector<size_t> sightings;
};

// Drops the worst ray until the rest agree.
std::optional<Meeting> Meet(std::vector<PosedRay> rays, double max_error_normalized) {
  std::vector<size_t> sightings(rays.size());
  std::iota(sightings.begin(), sightings.end(), size_t{0});
  while (rays.size() >= 2) {
    const std::optional<TriangulatedPoint> point = Triangulate(rays);
    if (!point) return std::nullopt;
    size_t worst = 0;
    double worst_error = 0.0;
    for (size_t i = 0; i < rays.size(); ++i) {
      const double error = NormalizedError(rays[i], point->point_in_world);
      if (error > worst_error) {
        worst = i;
        worst_error = error;
      }
    }
    if (worst_error <= max_error_normalized) return Meeting{*point, std::move(sightings)};
    rays.erase(rays.begin() + static_cast<std::ptrdiff_t>(worst));
    sightings.erase(sightings.begin() + static_cast<std::ptrdiff_t>(worst));
  }
  return std::nullopt;
}

// Cameras of all views with their readouts, made once and not per sighting.
std::vector<Camera> CamerasOf(const BlockState& state) {
  std::vector<Camera> cameras;
  cameras.reserve(state.readouts.size());
  for (size_t view = 0; view < state.readouts.size(); ++view) {
    cameras.push_back(state.CameraOf(view));
  }
  return cameras;
}

// Distance between sighting and projection, px; nothing when the point is behind the camera.
std::optional<double> ReprojectionError(const BlockState& state,
                                        const std::vector<Camera>& cameras,
                                        const BlockTrack& track,
                                        const Sighting& sighting) {
  const Eigen::Vector3d point_in_camera =
      Inverse(state.world_from_camera[sighting.view]) * track.point_in_world;
  const std::optional<Eigen::Vector2d> projection =
      cameras[sighting.view].ImageFromCamera(point_in_camera);
  if (!projection) return std::nullopt;
  return (*projection - sighting.point_in_image).norm();
}

// Errors of the inliers of tracks with a point, px.
std::vector<double> InlierErrors(const BlockState& state, const std::vector<BlockTrack>& tracks) {
  const std::vector<Camera> cameras = CamerasOf(state);
  std::vector<double> errors;
  errors.reserve(2 * tracks.size());
  for (const BlockTrack& track : tracks) {
    if (!track.has_point) continue;
    for (const Sighting& sighting : track.sightings) {
      const std::optional<double> error = ReprojectionError(state, cameras, track, sighting);
      if (sighting.is_inlier && error) errors.push_back(*error);
    }
  }
  return errors;
}

std::vector<PosedRay> Rays(const BlockState& state,
                           const std::vector<Camera>& cameras,
                           const BlockTrack& track) {
  std::vector<PosedRay> rays;
  rays.reserve(track.sightings.size());
  for (const Sighting& sighting : track.sightings) {
    rays.push_back({state.world_from_camera[sighting.view],
                    cameras[sighting.view].NormalizedFromImage(sighting.point_in_image)});
  }
  return rays;
}

// Mean of the points where the sightings' rays meet the ground below their views.
std::optional<Eigen::Vector3d> OnGround(const std::vector<View>& views,
                                        const BlockState& state,
                                        const std::vector<Camera>& cameras,
                                        const BlockTrack& track) {
  // Flatter rays meet the plane too far away.
  constexpr double kMinDescent = 0.2;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int count = 0;
  for (const Sighting& sighting : track.sightings) {
    const Rigid3d& world_from_camera = state.world_from_camera[sighting.view];
    const Eigen::Vector3d ray =
        world_from_camera.rotation * cameras[sighting.view].RayFromImage(sighting.point_in_image);
    if (ray.z() > -kMinDescent) continue;
    sum +=
        world_from_camera.translation + ray * (views[sighting.view].height_above_ground / -ray.z());
    ++count;
  }
  if (count == 0) return std::nullopt;
  return sum / count;
}

}  // namespace

Camera BlockState::CameraOf(size_t view) const { return camera.With(readouts[view]); }

int BlockTrack::NumInliers() const {
  return static_cast<int>(std::count_if(
      sightings.begin(), sightings.end(), [](const Sighting& s) { return s.is_inlier; }));
}

std::vector<BlockTrack> CollectTracks(const std::vector<View>& views) {
  std::map<int64_t, BlockTrack> by_id;
  for (size_t i = 0; i < views.size(); ++i) {
    for (const Observation& observation : views[i].observations) {
      std::vector<Sighting>& sightings = by_id[observation.track_id].sightings;
      const bool is_seen_before = !sightings.empty() && sightings.back().view == i;
      if (is_seen_before || !observation.point_in_image.allFinite()) continue;
      sightings.push_back({i, observation.point_in_image});
    }
  }
  std::vector<BlockTrack> tracks;
  for (auto& [id, track] : by_id) {
    track.id = id;
    if (track.sightings.size() >= 2) tracks.push_back(std::move(track));
  }
  return tracks;
}

void InitialiseOnGround(const std::vector<View>& views,
                        const BlockState& state,
                        std::vector<BlockTrack>& tracks) {
  const std::vector<Camera> cameras = CamerasOf(state);
  for (BlockTrack& track : tracks) {
    const std::optional<Eigen::Vector3d> point = OnGround(views, state, cameras, track);
    track.has_point = point.has_value();
    if (point) track.point_in_world = *point;
  }
}

void TriangulateTracks(const BlockState& state,
                       double min_parallax_deg,
                       double max_error_px,
                       std::vector<BlockTrack>& tracks) {
  const std::vector<Camera> cameras = CamerasOf(state);
  const double max_error_normalized = max_error_px / state.camera.MeanFocalPx();
  for (BlockTrack& track : tracks) {
    const std::optional<Meeting> meeting = Meet(Rays(state, cameras, track), max_error_normalized);
    track.has_point = meeting && DegFromRad(meeting->point.parallax) >= min_parallax_deg;
    if (!track.has_point) continue;
    track.point_in_world = meeting->point.point_in_world;
    for (Sighting& sighting : track.sightings) sighting.is_inlier = false;
    for (const size_t i : meeting->sightings) track.sightings[i].is_inlier = true;
  }
}

void MarkOutliers(const BlockState& state, double max_error_px, std::vector<BlockTrack>& tracks) {
  const std::vector<Camera> cameras = CamerasOf(state);
  for (BlockTrack& track : tracks) {
    if (!track.has_point) continue;
    for (Sighting& sighting : track.sightings) {
      const std::optional<double> error = ReprojectionError(state, cameras, track, sighting);
      sighting.is_inlier = error && *error <= max_error_px;
    }
    if (track.NumInliers() < 2) track.has_point = false;
  }
}

double WorstMedianError(const BlockState& state, const std::vector<BlockTrack>& tracks) {
  const std::vector<Camera> cameras = CamerasOf(state);
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  std::vector<std::vector<double>> errors(state.world_from_camera.size());
  for (const BlockTrack& track : tracks) {
    for (const Sighting& sighting : track.sightings) {
      errors[sighting.view].push_back(
          track.has_point ? ReprojectionError(state, cameras, track, sighting).value_or(kInfinity)
                          : kInfinity);
    }
  }
  double worst = 0.0;
  for (std::vector<double>& of_view : errors) {
    if (of_view.empty()) continue;
    const auto middle = of_view.begin() + static_cast<std::ptrdiff_t>(of_view.size() / 2);
    std::nth_element(of_view.begin(), middle, of_view.end());
    worst = std::max(worst, *middle);
  }
  return worst;
}

double MedianError(const BlockState& state, const std::vector<BlockTrack>& tracks) {
  std::vector<double> errors = InlierErrors(state, tracks);
  if (errors.empty()) return 0.0;
  const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
  std::nth_element(errors.begin(), middle, errors.end());
  return *middle;
}

double RmsError(const BlockState& state, const std::vector<BlockTrack>& tracks) {
  const std::vector<double> errors = InlierErrors(state, tracks);
  if (errors.empty()) return 0.0;
  double sum = 0.0;
  for (const double error : errors) sum += error * error;
  return std::sqrt(sum / static_cast<double>(errors.size()));
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
  // Near-parallel rays leave the variance undetermined, and rounding may give any value.
  const double variance = information.inverse()(2, 2);
  const bool is_known = std::isfinite(variance) && variance > 0.0;
  return is_known ? std::sqrt(variance) : std::numeric_limits<double>::infinity();
}

}  // namespace freelsd
