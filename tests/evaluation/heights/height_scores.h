// Input: a map and the world it is about. Output: the noise of its heights on open ground, how much
// of that ground it calls unknown or raised, and the fate of what stands there.
#pragma once

#include <array>
#include <map>
#include <string>
#include <vector>

#include "tests/evaluation/scores/map_shift.h"
#include "tests/evaluation/scores/things.h"
#include "tests/evaluation/statistics.h"

namespace freelsd {

// Open ground: meadow, stubble, soil, gravel and roads that at least three photographs show, with
// nothing else beside them.
struct OpenGroundScore {
  // Deviation of the height error within windows of 20 m, metres, of known cells.
  LogHistogram local_noise;
  // Error over the stated deviation, of known cells, windows of 20 m without their mean.
  Sums error_in_deviations;
  int64_t num_cells = 0;
  int64_t num_unknown = 0;
  // Known cells whose upper height is higher than the ground by more than 0.5 m.
  int64_t num_raised = 0;
};

// Things of at least 0.8 m, three pixels wide, that move by 1.5 pixels between the outermost views.
struct HeightScore {
  OpenGroundScore open;
  // By group: "crowns 1.5-4 m", "crowns 1.5-4 m, leafless", "higher crowns", "hedges", ... Counts
  // in the order of ThingFate.
  std::map<std::string, std::array<int64_t, kNumThingFates>> things;
  // Middle of each thing that is neither found nor unknown, to be looked at.
  std::vector<std::pair<std::string, Eigen::Vector2d>> missed;

  void Add(const HeightScore& other);
};

// Open ground with nothing else beside it: 255 or 0, by cell of the truth map.
cv::Mat1b OpenGround(const TruthMap& truth);

// Widest baseline over height of the photographs that show a place; 0 if fewer than two do.
double WidestBaselineRatio(const Scenario& scenario, const Eigen::Vector3d& place_in_world);

HeightScore ScoreHeights(const Scenario& scenario,
                         const TruthMap& truth,
                         const ElevationMap& map,
                         const HazardLayers& layers,
                         const MapOffset& offset);

}  // namespace freelsd
