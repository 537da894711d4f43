// A recorded flight in process: its photographs through the frontend and one adjustment of all,
// groups tied.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "engine/pipeline.h"

namespace freelsd {

struct RecordedFlight {
  LocalFrame frame;
  // As the first photograph tells.
  Camera camera;
  // By frame_id, which is the file's name; full size, BGR.
  std::map<std::string, cv::Mat> images;
  std::vector<View> views;
  AdjustedBlock block;
};

// What the frontend gets of a recorded flight. Frames are named like their files.
struct RecordedFrames {
  LocalFrame frame;
  Rig rig;
  std::vector<Frame> frames;
};

// Reads images/ and, where there is one, poses.csv in the folder, as the server takes them. Throws
// std::runtime_error when nothing can be read there.
RecordedFrames ReadRecordedFrames(const std::string& folder);
RecordedFlight AdjustRecordedFlight(const RecordedFrames& recorded,
                                    const GroundModel& ground_model,
                                    const PipelineOptions& options);

// How far the elevation maps of single pairs differ where they overlap, metres. Pairs are up to 30,
// evenly spread; a map cell is one metre.
struct PairAgreement {
  int num_overlaps = 0;
  double median_m = 0.0;
  double p90_m = 0.0;
};
PairAgreement AgreementOfPairs(const RecordedFlight& flight, const PipelineOptions& options);

// Elevation map of the whole block, as the engine makes it.
ElevationMap MapOfBlock(const RecordedFlight& flight, const PipelineOptions& options);

}  // namespace freelsd
