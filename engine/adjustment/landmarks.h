// Tracks of the views of a block, and their landmarks.
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

// Initial points from the current poses. If the rays of a track do not meet (poor poses), its point
// is on the ground plane below the first view that sees it.
void InitialiseOnGround(const std::vector<View>& views,
                        const BlockState& state,
                        std::vector<BlockTrack>& tracks);
// Points from rays. Repeatedly drops a track's worst sighting until all are within max_error_px. A
// track with one sighting, or too little parallax, loses its point. Sightings dropped earlier are
// tried again, because poses may have improved.
void TriangulateTracks(const BlockState& state,
                       double min_parallax_deg,
                       double max_error_px,
                       std::vector<BlockTrack>& tracks);

// Marks sightings beyond max_error_px as outliers, others as inliers. Drops points with one ray.
void MarkOutliers(const BlockState& state, double max_error_px, std::vector<BlockTrack>& tracks);
// Median error of the sightings of the worst view; infinite if half of them have no
// point.
double WorstMedianError(const BlockState& state, const std::vector<BlockTrack>& tracks);
// Root mean square over inliers of tracks with a point; 0 without any.
double RmsError(const BlockState& state, const std::vector<BlockTrack>& tracks);

// Height deviation of a track's point from its ray geometry for pixel_sd.
double HeightDeviation(const BlockState& state, const BlockTrack& track, double pixel_sd);

}  // namespace freelsd
