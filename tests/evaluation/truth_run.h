// Input: a world. Output: what the planner answers on maps without error, of the ground that the
// flight would see: a bound of what any engine could find by the same rules.
#pragma once

#include "tests/evaluation/engine_run.h"
#include "tests/evaluation/synthetic_flight.h"
#include "tests/evaluation/truth_map.h"

namespace freelsd {

// The rectangle of least area around the cells of a label, as a region that ten views saw as
// grass.
Region RegionAround(const cv::Mat1i& label, int id, const TruthMap& truth);
// To touch down in a region, in that wind.
PlanRequest RequestFor(const Region& region, const Eigen::Vector2d& wind_in_world);

// One site per field, touching down within it, in the true wind. Maps have the deviation that
// blocks of such flights state, so the planner keeps the same margins.
EngineRun RunOnTruth(const Scenario& scenario,
                     const TruthMap& truth,
                     const Fields& fields,
                     const ApproachOptions& options);

}  // namespace freelsd
