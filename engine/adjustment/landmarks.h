// Feature tracks through the views of a block, and their landmarks.
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "engine/adjustment/adjustment.h"

namespace freelsd {

struct Sighting {
  size_t view = 0;
  Eigen::Vector2d point_in_image = Eigen::Vector2d::Zero();
  bool is_inlier = true;
};

struct BlockTrack {
  int64_t id = 0;
  std::vector<Sighting> sightings;  // by view, ascending
  Eigen::Vector3d point_in_world = Eigen::Vector3d::Zero();
  bool has_point = false;

  int NumInliers() const;
};

// Poses and intrinsics during the adjustment.
struct BlockState {
  Camera camera;
  std::vector<Rigid3d> world_from_camera;
  std::vector<Readout> readouts;

  Camera CameraOf(size_t view) const;
};

// Tracks with at least two sightings, in order of track id.
std::vector<BlockTrack> CollectTracks(const std::vector<View>& views);

// Sets initial points that are usable even with poor poses. Each ray of a track is intersected with
// the level ground below its view. The point is the mean of these intersections. A track whose rays
// are all too close to horizontal gets no point.
void InitialiseOnGround(const std::vector<View>& views,
                        const BlockState& state,
                        std::vector<BlockTrack>& tracks);
// Triangulates points. Drops the worst sighting of a track, and repeats this until the error of
// each remaining sighting is at most max_error_px. A track with fewer than two sightings left, or
// with too little parallax, loses its point. Sightings that an earlier call dropped are tried
// again, because the poses may have improved.
void TriangulateTracks(const BlockState& state,
                       double min_parallax_deg,
                       double max_error_px,
                       std::vector<BlockTrack>& tracks);

// Marks sightings beyond max_error_px as outliers, others as inliers. A track with fewer than two
// inliers loses its point.
void MarkOutliers(const BlockState& state, double max_error_px, std::vector<BlockTrack>& tracks);
// Largest median reprojection error of a view, px; infinite if half of a view's sightings have no
// point.
double WorstMedianError(const BlockState& state, const std::vector<BlockTrack>& tracks);
// Median reprojection error of the inliers of tracks with a point, px; 0 without inliers.
double MedianError(const BlockState& state, const std::vector<BlockTrack>& tracks);
// Root mean square reprojection error of the inliers of tracks with a point, px; 0 without inliers.
double RmsError(const BlockState& state, const std::vector<BlockTrack>& tracks);

// Standard deviation of the height of a track's point if each inlier has the deviation pixel_sd.
// Infinite if the rays are nearly parallel.
double HeightDeviation(const BlockState& state, const BlockTrack& track, double pixel_sd);

}  // namespace freelsd
