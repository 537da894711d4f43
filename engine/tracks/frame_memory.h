// State of the frames of one flight, and of the tracks that join them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "engine/tracks/descriptor_matching.h"
#include "engine/tracks/track_table.h"
#include "engine/tracks/tracks.h"

namespace freelsd {

// Verified matches with another frame; a: index of a point here, b: index there.
struct Link {
  size_t other = 0;
  std::vector<IndexPair> pairs;
};

struct FrameRecord {
  // The image is dropped once the frame is returned.
  Frame frame;
  // Followed corners, then described keypoints; distorted pixels of the full-size image.
  std::vector<Eigen::Vector2d> points;
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
  // Only while it waits.
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
