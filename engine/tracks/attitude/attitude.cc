#include "engine/tracks/attitude/attitude.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "engine/tracks/attitude/attitude_check.h"

namespace freelsd {
namespace {

// More matches of one pair add nothing, because they share errors.
constexpr size_t kMaxMatchesPerPair = 80;
// A turn this near to 180 deg counts as a photograph rotated by a viewer (90 deg would change its
// size). Generous, because rotation mirrors the tilt too.
constexpr double kHalfTurnToleranceDeg = 40.0;
// Remaining error of a heading that was corrected by GPS baselines.
constexpr double kTurnedAttitudeSdDeg = 10.0;
// Headings with a larger deviation are not trusted.
constexpr double kMaxHeadingSdDeg = 15.0;

AlignmentPair PairOf(const FrameMemory& memory, size_t frame, const Link& link) {
  AlignmentPair pair;
  const size_t stride = 1 + link.pairs.size() / kMaxMatchesPerPair;
  for (size_t i = 0; i < link.pairs.size(); i += stride) {
    pair.points_a.push_back(memory.Normalized(frame, link.pairs[i].a));
    pair.points_b.push_back(memory.Normalized(link.other, link.pairs[i].b));
  }
  return pair;
}

bool IsView(const FrameMemory& memory, size_t frame) {
  return memory.frames[frame].view.has_value();
}

OrientedFrame OrientedOf(const FrameRecord& record) {
  return {record.world_from_camera->translation,
          record.frame.prior.position_sd_m,
          record.world_from_camera->rotation,
          RadFromDeg(record.attitude_sd_deg)};
}

AlignmentFrame HeldFrame(const FrameRecord& record) {
  AlignmentFrame frame;
  frame.position_in_world = record.world_from_camera->translation;
  frame.position_sd_m = record.frame.prior.position_sd_m;
  frame.is_held = true;
  frame.world_from_camera = record.world_from_camera->rotation;
  frame.height_above_ground = *record.height_above_ground;
  return frame;
}

AlignmentFrame FreeFrame(const FrameRecord& record) {
  AlignmentFrame frame;
  frame.position_in_world = record.PriorPosition();
  frame.position_sd_m = record.frame.prior.position_sd_m;
  return frame;
}

bool LacksAttitude(const FrameRecord& record) {
  return record.is_waiting && !record.world_from_camera;
}

}  // namespace

std::optional<double> NeededTurn(const FrameMemory& memory, size_t frame) {
  const FrameRecord& record = memory.frames[frame];
  std::vector<double> by_baseline, by_neighbours;
  for (const Link& link : record.links) {
    const FrameRecord& other = memory.frames[link.other];
    if (!other.world_from_camera) continue;
    const auto evidence = CompareAttitudes(OrientedOf(other), OrientedOf(record), [&] {
      AlignmentPair pair = PairOf(memory, frame, link);
      std::swap(pair.points_a, pair.points_b);
      return pair;
    }());
    if (!evidence) continue;
    if (evidence->turn_of_b) by_baseline.push_back(*evidence->turn_of_b);
    if (other.view) by_neighbours.push_back(evidence->turn_of_b_against_a);
  }
  const double limit = RadFromDeg(memory.options.max_attitude_disagreement_deg);
  const auto absolute = MedianTurn(by_baseline), relative = MedianTurn(by_neighbours);
  const auto turn = absolute ? absolute : relative;
  if (!turn || std::abs(*turn) <= limit) return std::nullopt;
  // Neighbours that agree with the frame confirm its attitude, so the position is wrong.
  if (relative && std::abs(WrapAngle(*relative - *turn)) > limit) return std::nullopt;
  return turn;
}

void TurnFrame(FrameRecord& record, double turn) {
  Eigen::Quaterniond& rotation = record.world_from_camera->rotation;
  if (std::abs(turn) > kPi - RadFromDeg(kHalfTurnToleranceDeg)) {
    rotation = rotation * Eigen::AngleAxisd(kPi, Eigen::Vector3d::UnitZ());
  } else {
    rotation = Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()) * rotation;
    record.attitude_sd_deg = std::max(record.attitude_sd_deg, kTurnedAttitudeSdDeg);
  }
  rotation.normalize();
}

std::vector<std::vector<size_t>> WaitingComponents(const FrameMemory& memory) {
  // Label of every frame, posed neighbours included: they connect the frames that they match.
  std::map<size_t, size_t> label;
  for (size_t i = 0; i < memory.frames.size(); ++i) {
    if (LacksAttitude(memory.frames[i])) label[i] = i;
  }
  bool has_changed = true;
  while (has_changed) {
    has_changed = false;
    for (auto& [frame, own] : label) {
      for (const Link& link : memory.frames[frame].links) {
        const bool is_posed = IsView(memory, link.other);
        if (!is_posed && label.count(link.other) == 0) continue;
        const auto [entry, is_new] = label.try_emplace(link.other, own);
        const size_t lower = std::min(own, entry->second);
        has_changed = has_changed || is_new || own != lower || entry->second != lower;
        own = lower;
        entry->second = lower;
      }
    }
  }
  std::map<size_t, std::vector<size_t>> components;
  for (const auto& [frame, own] : label) {
    if (LacksAttitude(memory.frames[frame])) components[own].push_back(frame);
  }
  std::vector<std::vector<size_t>> result;
  result.reserve(components.size());
  for (auto& [own, component] : components) result.push_back(std::move(component));
  return result;
}

bool HasPosedNeighbour(const FrameMemory& memory, const std::vector<size_t>& component) {
  for (const size_t frame : component) {
    for (const Link& link : memory.frames[frame].links) {
      if (IsView(memory, link.other)) return true;
    }
  }
  return false;
}

std::vector<AlignmentFrame> SolveAttitudes(const FrameMemory& memory,
                                           const std::vector<size_t>& component) {
  std::vector<AlignmentFrame> frames;
  std::map<size_t, size_t> slot;
  for (const size_t frame : component) {
    slot[frame] = frames.size();
    frames.push_back(FreeFrame(memory.frames[frame]));
  }
  std::vector<AlignmentPair> pairs;
  for (const size_t frame : component) {
    for (const Link& link : memory.frames[frame].links) {
      if (slot.count(link.other) == 0) {
        if (!IsView(memory, link.other)) continue;
        slot[link.other] = frames.size();
        frames.push_back(HeldFrame(memory.frames[link.other]));
      } else if (!frames[slot[link.other]].is_held && link.other > frame) {
        continue;  // the later frame of two brings their pair
      }
      AlignmentPair pair = PairOf(memory, frame, link);
      pair.a = slot[frame];
      pair.b = slot[link.other];
      pairs.push_back(std::move(pair));
    }
  }
  frames = AlignToGround(std::move(frames),
                         pairs,
                         {.nadir_sd = RadFromDeg(memory.options.nadir_sd_deg),
                          .max_heading_sd = RadFromDeg(kMaxHeadingSdDeg)});
  frames.resize(component.size());
  return frames;
}

}  // namespace freelsd
