// Input: what the stages made, and the world. Output: how far each is from the truth.
#pragma once

#include <array>
#include <map>
#include <string>

#include "tests/evaluation/engine_run.h"
#include "tests/evaluation/scores/elevation_error.h"
#include "tests/evaluation/statistics.h"
#include "tests/evaluation/synthetic_flight.h"
#include "tests/evaluation/truth_map.h"

namespace freelsd {

struct PoseScore {
  int num_views = 0;
  int num_connected = 0;
  double rms_after_px = 0.0;
  // Mean error of the connected views, estimate less truth: the block's rigid shift.
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();
};
PoseScore ScorePoses(const EngineRun& run, const Scenario& scenario);

struct MapScore {
  // Estimate less truth of open ground: metres, and with the world's median taken off.
  Sums elevation_error, elevation_error_unbiased;
  double elevation_median_error = 0.0;
  // The same errors without their plane.
  DetiltedErrors detilted;
  // Cells of the map, by what they truly are ("landable", a cover, "steep", "rough"), at least
  // 2 m inside of it: free, hazard, unseen.
  std::map<std::string, std::array<int64_t, 3>> hazard_of_kind;
};
MapScore ScoreMap(const EngineRun& run, const Scenario& scenario, const TruthMap& truth);

// Per region of a view: its probability of grass against what most of it is.
RocCounts ScoreRegions(const EngineRun& run, const Scenario& scenario);

}  // namespace freelsd
