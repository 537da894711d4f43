// Input: an engine's run over a world. Output: of each field, what the planner answers on maps
// without error, and which of its rules keeps it from the engine's map.
#pragma once

#include <string>
#include <vector>

#include "tests/evaluation/engine_run.h"
#include "tests/evaluation/synthetic_flight.h"
#include "tests/evaluation/truth_map.h"

namespace freelsd {

struct FieldScore {
  // An accepted site of the engine touches down in it.
  bool is_found = false;
  // The planner's answer on maps without error, of the ground that was photographed.
  bool is_accepted_on_truth = false;
  // Why not; empty if accepted.
  std::string reason_on_truth;
  // The planner's touchdown if it accepts the field there, else the roomiest one of the field.
  Eigen::Vector2d touchdown = Eigen::Vector2d::Zero();
  // What is truly wrong with the plan that is accepted on maps without error; empty if nothing.
  std::string fault_on_truth;
  // Fences, poles or wires alone are wrong with it.
  bool is_only_thin_on_truth = false;
  // Share of disc, ground roll and final at `touchdown` that was photographed often enough.
  double photographed_ratio = 0.0;
  // Of a field that was not found: the first rule of the planner that fails at `touchdown` on the
  // engine's map, "no map", or "accepted if asked".
  std::string lost_reason;
};

// In the order of the fields.
std::vector<FieldScore> ScoreFields(const Scenario& scenario,
                                    const EngineRun& run,
                                    const TruthMap& truth,
                                    const Fields& fields,
                                    const PipelineOptions& options);

// Field at a place: its id, 0 where none is.
int FieldAt(const Fields& fields, const TruthMap& truth, const Eigen::Vector2d& place);

// A request as the engine makes it: for the wind that the run measured, else for the true one.
PlanRequest RequestOfRun(const EngineRun& run, const Scenario& scenario, const Region& region);

}  // namespace freelsd
