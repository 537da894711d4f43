#include "engine/tracks/coarse_depth.h"

#include <algorithm>
#include <cmath>

namespace freelsd {
namespace {

// More rays of a long track add cost, not accuracy.
constexpr size_t kMaxRaysPerTrack = 8;
// Fewer landmarks do not determine the ground.
constexpr size_t kMinLandmarks = 10;
constexpr size_t kMinLandmarksNearby = 3;
// Landmarks farther above or below the ground than this share of the height are mismatches.
constexpr double kMaxReliefRatio = 0.6;
// Flatter rays meet the ground too far away to be useful.
constexpr double kMinDepressionDeg = 3.0;
// Limits the weight of a landmark at the very pixel.
constexpr double kMinDistancePx = 5.0;

// Members whose frames have a pose; an even selection of a long track, including both ends.
std::vector<TrackMember> PosedMembers(const FrameMemory& memory, int64_t track_id) {
  std::vector<TrackMember> posed;
  for (const TrackMember& member : memory.table.MembersOf(track_id)) {
    const FrameRecord& record = memory.frames[member.frame];
    if (record.world_from_camera && (record.is_waiting || record.view)) posed.push_back(member);
  }
  if (posed.size() <= kMaxRaysPerTrack) return posed;
  std::vector<TrackMember> selected;
  for (size_t i = 0; i < kMaxRaysPerTrack; ++i) {
    selected.push_back(posed[i * (posed.size() - 1) / (kMaxRaysPerTrack - 1)]);
  }
  return selected;
}

std::optional<TriangulatedPoint> TriangulateTrack(const FrameMemory& memory, int64_t track_id) {
  std::vector<PosedRay> rays;
  for (const TrackMember& member : PosedMembers(memory, track_id)) {
    const Observation& observation = memory.table.ObservationsOf(member.frame)[member.observation];
    rays.push_back({*memory.frames[member.frame].world_from_camera,
                    memory.CameraOf(member.frame).NormalizedFromImage(observation.point_in_image)});
  }
  return Triangulate(rays);
}

}  // namespace

double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::vector<CoarseLandmark> TriangulateLandmarks(const FrameMemory& memory, size_t frame) {
  const FrameRecord& record = memory.frames[frame];
  std::vector<CoarseLandmark> landmarks;
  if (!record.world_from_camera) return landmarks;
  const double max_error =
      memory.options.max_reprojection_error_px / memory.rig.camera.MeanFocalPx();
  const double min_parallax = RadFromDeg(memory.options.min_parallax_deg);
  const double camera_z = record.world_from_camera->translation.z();
  for (const Observation& observation : memory.table.ObservationsOf(frame)) {
    const auto point = TriangulateTrack(memory, observation.track_id);
    if (!point || point->parallax < min_parallax) continue;
    if (point->rms_error_normalized > max_error) continue;
    const double depth = camera_z - point->point_in_world.z();
    if (depth <= 0.0) continue;
    if (record.height_above_ground && std::abs(depth - *record.height_above_ground) >
                                          kMaxReliefRatio * *record.height_above_ground) {
      continue;
    }
    landmarks.push_back({observation.point_in_image, point->point_in_world, point->parallax});
  }
  return landmarks;
}

std::optional<GroundHeight> GroundFromLandmarks(const std::vector<CoarseLandmark>& landmarks,
                                                const FrameRecord& record) {
  if (landmarks.size() < kMinLandmarks) return std::nullopt;
  std::vector<double> heights, parallaxes;
  for (const CoarseLandmark& landmark : landmarks) {
    heights.push_back(landmark.point_in_world.z());
    parallaxes.push_back(landmark.parallax);
  }
  GroundHeight ground;
  ground.z = Median(heights);
  // Two independent attitudes tilt the rays against each other, two positions shift them.
  const double height = record.world_from_camera->translation.z() - ground.z;
  const double parallax = Median(parallaxes);
  const double angle_sd = RadFromDeg(record.attitude_sd_deg);
  const double shift_sd = record.frame.prior.position_sd_m;
  ground.sd_m = std::sqrt(2.0) * std::hypot(height * angle_sd, shift_sd) / parallax;
  return ground;
}

std::optional<Eigen::Vector3d> IntersectGround(const Camera& camera,
                                               const Rigid3d& world_from_camera,
                                               const Eigen::Vector2d& point_in_image,
                                               double ground_height) {
  const Eigen::Vector3d ray = world_from_camera.rotation * camera.RayFromImage(point_in_image);
  if (!ray.allFinite() || -ray.z() < std::sin(RadFromDeg(kMinDepressionDeg))) return std::nullopt;
  const double down = ground_height - world_from_camera.translation.z();
  if (down >= 0.0) return std::nullopt;
  return world_from_camera.translation + ray * (down / ray.z());
}

std::optional<GroundHeight> HeightNear(const std::vector<CoarseLandmark>& landmarks,
                                       const Eigen::Vector2d& point_in_image,
                                       int num_nearest) {
  if (landmarks.size() < kMinLandmarksNearby) return std::nullopt;
  std::vector<std::pair<double, double>> nearest;  // squared distance, height
  nearest.reserve(landmarks.size());
  for (const CoarseLandmark& landmark : landmarks) {
    nearest.emplace_back((landmark.point_in_image - point_in_image).squaredNorm(),
                         landmark.point_in_world.z());
  }
  const size_t count = std::min(nearest.size(), static_cast<size_t>(num_nearest));
  std::partial_sort(
      nearest.begin(), nearest.begin() + static_cast<std::ptrdiff_t>(count), nearest.end());
  double sum = 0.0, sum_z = 0.0, sum_zz = 0.0;
  for (size_t i = 0; i < count; ++i) {
    const double weight = 1.0 / std::max(std::sqrt(nearest[i].first), kMinDistancePx);
    sum += weight;
    sum_z += weight * (nearest[i].second - nearest[0].second);
    sum_zz += weight * std::pow(nearest[i].second - nearest[0].second, 2);
  }
  const double mean = sum_z / sum;
  return GroundHeight{nearest[0].second + mean,
                      std::sqrt(std::max(0.0, sum_zz / sum - mean * mean))};
}

}  // namespace freelsd
