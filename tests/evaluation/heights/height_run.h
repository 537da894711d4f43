// Input: a seeded world. Output: its heights by pairs and by all photographs, on the same poses.
#pragma once

#include <map>
#include <string>

#include "engine/classification/classification.h"
#include "tests/evaluation/engine_run.h"
#include "tests/evaluation/heights/height_scores.h"

namespace freelsd {

struct MethodResult {
  HeightScore score;
  // Seconds by stage of the backend, and of the whole engine.
  std::map<std::string, double> seconds;
  double total_seconds = 0.0;
  double hectares = 0.0;
  // Sites that the engine accepts, and those of them that are false safe (site_score.h), but for
  // fences, poles and wires.
  int num_accepted = 0;
  int num_false_safe = 0;

  void Add(const MethodResult& other);
};

struct HeightRun {
  Scenario scenario;
  TruthMap truth;
  // The engine's run by pairs; the other evaluation has the same block.
  EngineRun pairs;
  Evaluation photographs;
  // What was measured for it.
  PhotographHeights heights;
  MapOffset offset;
  std::map<HeightMethod, MethodResult> results;
};

HeightRun RunHeights(uint64_t seed,
                     const ScenarioOptions& scenario,
                     const PipelineOptions& options,
                     const Classifier& classifier);

}  // namespace freelsd
