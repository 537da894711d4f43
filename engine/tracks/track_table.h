// Joins matches into tracks over frames. A track has at most one observation per frame.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "engine/tracks/tracks.h"

namespace freelsd {

struct TrackMember {
  size_t frame = 0;
  // Index into the frame's observations.
  size_t observation = 0;
};

class TrackTable {
 public:
  // Adds the next frame, without points.
  void AddFrame();
  // A point of a frame.
  struct Place {
    size_t frame = 0;
    int point = 0;
    Eigen::Vector2d point_in_image = Eigen::Vector2d::Zero();
  };
  // Joins the tracks of two points that show the same place. Ignored if the joined track would have
  // two observations in one frame.
  void Join(const Place& a, const Place& b);

  const std::vector<Observation>& ObservationsOf(size_t frame) const {
    return frames_[frame].observations;
  }
  // Track of a frame's point; nothing if it was never matched.
  std::optional<int64_t> TrackOf(size_t frame, int point) const;
  const std::vector<TrackMember>& MembersOf(int64_t track_id) const;
  // Frames whose observations changed since the last call, ascending.
  std::vector<size_t> TakeChangedFrames();

 private:
  struct FrameEntry {
    std::vector<Observation> observations;
    // Observation of a point, once it belongs to a track.
    std::map<int, size_t> observation_of_point;
  };
  void Append(int64_t track_id, const Place& place);
  bool CanMerge(int64_t a, int64_t b) const;
  void Merge(int64_t into, int64_t from);

  std::vector<FrameEntry> frames_;
  std::map<int64_t, std::vector<TrackMember>> tracks_;
  int64_t next_track_id_ = 0;
  std::set<size_t> changed_;
};

}  // namespace freelsd
