// A recorded flight in process.
#pragma once

#include <string>
#include <vector>

#include "engine/pipeline.h"

namespace freelsd {

// What the frontend gets of a recorded flight. Frames are named like their files.
struct RecordedFrames {
  LocalFrame frame;
  Rig rig;
  std::vector<Frame> frames;
};

// Reads images/ and, where there is one, poses.csv in the folder, as the server takes them. Throws
// std::runtime_error when nothing can be read there.
RecordedFrames ReadRecordedFrames(const std::string& folder);

}  // namespace freelsd
