// Input: the folder of a rendered flight (freelsd-render). Output: what each stage made of it.
#pragma once

#include <string>
#include <vector>

#include "engine/pipeline.h"
#include "tests/evaluation/stages/stage_record.h"

namespace freelsd {

// What the engine gets of the folder, as the service gives it.
struct FlightFolder {
  Rig rig;
  Aircraft aircraft;
  PipelineOptions options;
  std::vector<Frame> frames;
};
// At most that many photographs; the first ones.
FlightFolder ReadFlightFolder(const std::string& folder, size_t max_num_frames);

// One stage after the other, each on what the one before made.
StageRecords RunStages(const FlightFolder& flight);

// Stages whose input does not come from a stage that OpenCV or Ceres computes. All start
// from `adjusted`, which RunStages recorded.
StageRecords RunStagesAlone(const FlightFolder& flight, const StageRecords& adjusted);

}  // namespace freelsd
