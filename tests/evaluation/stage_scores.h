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
  // Of connected views. Metres, degrees; before: the autopilot's.
  Sums horizontal_before, horizontal_after;
  Sums vertical_before, vertical_after;
  Sums attitude_before, attitude_after;
  double rms_before_px = 0.0;
  double rms_after_px = 0.0;
  // Mean error of the connected views, estimate less truth: the block's rigid shift.
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();
  // Horizontal error that is left when the shift is taken off.
  Sums horizontal_within;
};
PoseScore ScorePoses(const EngineRun& run, const Scenario& scenario);

struct MapScore {
  // Estimate less truth of open ground: metres, and with the world's median taken off.
  Sums elevation_error, elevation_error_unbiased;
  double elevation_median_error = 0.0;
  // The same errors without their plane.
  DetiltedErrors detilted;
  // Of landable ground with none but such around it: degrees, metres.
  Sums slope_error, roughness_error;
  // Cells of the map, by what they truly are ("landable", a cover, "steep", "rough"), at least
  // 2 m inside of it: free, hazard, unseen.
  std::map<std::string, std::array<int64_t, 3>> hazard_of_kind;
  // Of all cells that the map saw.
  int64_t num_faulty = 0, num_faulty_not_free = 0;
  int64_t num_called_hazard = 0, num_called_hazard_rightly = 0;
  // Per cell that the map saw: the posterior of grass by the views alone, against what it is.
  RocCounts grass_by_views;
};
MapScore ScoreMap(const EngineRun& run, const Scenario& scenario, const TruthMap& truth);

struct FrontendScore {
  // Sampled pixels by cover: called grass, called something else, not called anything.
  std::map<std::string, std::array<int64_t, 3>> pixels_of_cover;
  // Height of region corners over the true ground there, estimate less truth, metres.
  Sums coarse_height_error;
  int num_regions = 0;
  int num_graded = 0;
  // Regions that share more than 0.3 of their ground with a better one.
  int num_duplicates = 0;
  // Views per track.
  Sums track_length;
};
FrontendScore ScoreFrontend(const EngineRun& run, const Scenario& scenario);

}  // namespace freelsd
