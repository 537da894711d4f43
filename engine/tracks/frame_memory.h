// State of the frames of one flight, and of the tracks that connect them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "engine/tracks/descriptor_matching.h"
#include "engine/tracks/keypoints.h"
#include "engine/tracks/track_table.h"
#include "engine/tracks/tracks.h"

namespace freelsd {

// Verified matches of a frame with the frame `other`. In each pair, `a` is a point of this frame
// and `b` a point of the other.
struct Link {
  size_t other = 0;
  std::vector<IndexPair> pairs;
};

struct FrameRecord {
  // Its image is released when the frame is returned to the caller.
  Frame frame;
  // First tracked corners, then keypoints with descriptors. Distorted pixels of the full-size
  // image.
  std::vector<Eigen::Vector2d> points;
  // Reduced image, from which points are followed to later frames; empty if no longer needed.
  TrackingImage image;
  // Descriptors of the points from first_described on; empty if not computed or no longer needed.
  cv::Mat descriptors;
  int first_described = 0;
  // Best current pose; nothing while the attitude is unknown.
  std::optional<Rigid3d> world_from_camera;
  Readout readout;
  AttitudeSource attitude_source = AttitudeSource::kGiven;
  double attitude_sd_deg = 2.0;
  std::optional<double> height_above_ground;
  // Index of the frame's view, once it has one.
  std::optional<size_t> view;
  bool is_waiting = true;
  std::string note;
  // Kept only while the frame waits.
  std::vector<Link> links;

  Eigen::Vector3d PriorPosition() const { return frame.prior.position_in_world; }
};

struct FrameMemory {
  Rig rig;
  TracksOptions options;
  std::vector<FrameRecord> frames;
  TrackTable table;

  Camera CameraOf(size_t frame) const { return rig.camera.With(frames[frame].readout); }
  Eigen::Vector2d Normalized(size_t frame, int point) const {
    return CameraOf(frame).NormalizedFromImage(frames[frame].points[point]);
  }
};

}  // namespace freelsd
