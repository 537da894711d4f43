// Input: the frames of a flight. Output: everything the engine made of them, with what it cost.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "engine/pipeline.h"

namespace freelsd {

struct EngineRun {
  // With the reports of frontend and backend.
  Evaluation evaluation;
  Snapshot snapshot;
  // What the frontend knew of, graded or not.
  std::vector<Region> regions;
  int num_processed = 0;
  // Until the last frame was through the frontend, and until all sites were there.
  double frontend_seconds = 0.0;
  double total_seconds = 0.0;

  // By stage, as the reports of the engine name them.
  std::map<std::string, double> StageSeconds() const;
};

// Makes the sites of a flight; may change what the frontend knew.
using EvaluateFlight = std::function<Evaluation(Snapshot& snapshot,
                                                const RegionGroup& group,
                                                const ImageSource& images,
                                                const PipelineOptions& options,
                                                const Progress& progress)>;

// What the engine gets of a flight. All must outlive it.
struct EngineInput {
  const Rig& rig;
  const std::vector<Frame>& frames;
  const Aircraft& aircraft;
  // What photographs do not show.
  std::vector<HardObstacle> obstacles = {};
  // Nothing is planned: the run ends with the map.
  bool ends_with_map = false;
  // Nothing: EvaluateSites.
  EvaluateFlight evaluate = {};
};

// The ground_model that the service uses with these options, from the sources.
std::string ModelFileFor(const PipelineOptions& options);

// As Detect does, stage by stage, so that nothing of what lies between is lost.
EngineRun RunEngine(const EngineInput& input,
                    const PipelineOptions& options,
                    const GroundModel& ground_model,
                    const Progress& progress);

}  // namespace freelsd
