// Joins a new frame with earlier ones: follows corners after small motion, matches descriptors
// after large motion.
#pragma once

#include <optional>

#include "engine/tracks/frame_memory.h"

namespace freelsd {

class FrameLinker {
 public:
  // Finds points and links of the newest frame and joins the tracks. `ground_height` is the world z
  // of the ground, if known.
  void LinkNewest(FrameMemory& memory, std::optional<double> ground_height);

 private:
  bool ShouldFollow(const FrameMemory& memory, std::optional<double> ground_height) const;
  bool LinkByFollowing(FrameMemory& memory, std::optional<double> ground_height);
  void Refill(FrameMemory& memory, size_t frame) const;
  void LinkByDescriptors(FrameMemory& memory, std::optional<double> ground_height);
  void MatchPair(FrameMemory& memory, size_t newest, size_t other);

  // Of the newest frame and of its predecessor.
  TrackingImage image_;
  TrackingImage previous_image_;
  // Median displacement between the last two linked frames, share of the image width.
  std::optional<double> last_flow_ratio_;
};

}  // namespace freelsd
