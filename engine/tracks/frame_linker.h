// Links a new frame to earlier ones. If the motion is small, corners are followed from the
// predecessor. Else, if poses and ground are known, corners are followed from where they predict
// them. Else, or if this fails, descriptors are matched.
#pragma once

#include <optional>

#include "engine/tracks/frame_memory.h"

namespace freelsd {

class FrameLinker {
 public:
  // Finds points of the newest frame, links it to earlier frames and joins their tracks.
  // `ground_height` is the world z of the ground, if known.
  void LinkNewest(FrameMemory& memory, std::optional<double> ground_height);

 private:
  bool ShouldFollow(const FrameMemory& memory, std::optional<double> ground_height) const;
  bool LinkByFollowing(FrameMemory& memory, std::optional<double> ground_height);
  bool LinkByPrediction(FrameMemory& memory, double ground_height);
  void LinkByDescriptors(FrameMemory& memory, std::optional<double> ground_height);
  void AcceptPair(FrameMemory& memory, size_t other, std::vector<IndexPair>& matches);

  // Median displacement of points between the newest frame and its predecessor, as a share of the
  // image width. Nothing if the two are not linked.
  std::optional<double> last_flow_ratio_;
};

}  // namespace freelsd
