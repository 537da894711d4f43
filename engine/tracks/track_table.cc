#include "engine/tracks/track_table.h"

#include <utility>

namespace freelsd {

void TrackTable::AddFrame() { frames_.emplace_back(); }

std::optional<int64_t> TrackTable::TrackOf(size_t frame, int point) const {
  const FrameEntry& entry = frames_[frame];
  const auto found = entry.observation_of_point.find(point);
  if (found == entry.observation_of_point.end()) return std::nullopt;
  return entry.observations[found->second].track_id;
}

const std::vector<TrackMember>& TrackTable::MembersOf(int64_t track_id) const {
  return tracks_.at(track_id);
}

void TrackTable::Append(int64_t track_id, const Place& place) {
  FrameEntry& entry = frames_[place.frame];
  entry.observation_of_point[place.point] = entry.observations.size();
  tracks_[track_id].push_back({place.frame, entry.observations.size()});
  entry.observations.push_back({track_id, place.point_in_image});
  changed_.insert(place.frame);
}

bool TrackTable::CanMerge(int64_t a, int64_t b) const {
  std::set<size_t> frames;
  for (const TrackMember& member : tracks_.at(a)) frames.insert(member.frame);
  for (const TrackMember& member : tracks_.at(b)) {
    if (frames.count(member.frame) > 0) return false;
  }
  return true;
}

void TrackTable::Merge(int64_t into, int64_t from) {
  std::vector<TrackMember>& members = tracks_.at(into);
  for (const TrackMember& member : tracks_.at(from)) {
    frames_[member.frame].observations[member.observation].track_id = into;
    members.push_back(member);
    changed_.insert(member.frame);
  }
  tracks_.erase(from);
}

void TrackTable::Join(const Place& a, const Place& b) {
  const std::optional<int64_t> track_a = TrackOf(a.frame, a.point);
  const std::optional<int64_t> track_b = TrackOf(b.frame, b.point);
  if (track_a && track_b) {
    if (*track_a == *track_b || !CanMerge(*track_a, *track_b)) return;
    const bool a_is_longer = tracks_.at(*track_a).size() >= tracks_.at(*track_b).size();
    Merge(a_is_longer ? *track_a : *track_b, a_is_longer ? *track_b : *track_a);
    return;
  }
  if (!track_a && !track_b) {
    const int64_t track_id = next_track_id_++;
    Append(track_id, a);
    Append(track_id, b);
    return;
  }
  const int64_t track_id = track_a ? *track_a : *track_b;
  const Place& newcomer = track_a ? b : a;
  for (const TrackMember& member : tracks_.at(track_id)) {
    if (member.frame == newcomer.frame) return;
  }
  Append(track_id, newcomer);
}

std::vector<size_t> TrackTable::TakeChangedFrames() {
  std::vector<size_t> changed(changed_.begin(), changed_.end());
  changed_.clear();
  return changed;
}

}  // namespace freelsd
