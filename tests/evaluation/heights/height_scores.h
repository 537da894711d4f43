// Input: the map of an engine's run, and the world. Output: how far its heights of open ground are
// from the truth, and whether its deviations say so.
//
// Counted are cells of open ground that at least three photographs see. Errors are those of the
// elevation, estimate less true surface. What all cells of a world have in common is taken off: a
// plane, or the median alone.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <map>
#include <string>

#include <nlohmann/json.hpp>

#include "engine/hazard/hazard.h"
#include "tests/evaluation/statistics.h"
#include "tests/evaluation/synthetic_flight.h"
#include "tests/evaluation/truth_map.h"

namespace freelsd {

// Of some cells, metres.
struct HeightErrors {
  Sums errors;
  // Of their sizes.
  FineHistogram sizes;
  double largest = 0.0;
  // Cells whose deviation is told, and those of them that are off by more than 2 and 3 of it.
  int64_t num_told = 0, num_beyond_2 = 0, num_beyond_3 = 0;

  void Add(double error, double told_sd);
  void Add(const HeightErrors& other);
};

// Cells whose told deviation is in a bin, metres.
struct ToldDeviations {
  Sums told, errors;

  void Add(const ToldDeviations& other);
};

struct HeightScores {
  // Cells within this distance of something that stands at least kTallM above the ground are near.
  static constexpr double kNearM = 3.0;
  static constexpr double kTallM = 5.0;
  // Lower edges of the bins of told deviations, metres; the last one is open.
  static constexpr std::array<double, 8> kToldEdges{0.0, 0.05, 0.1, 0.15, 0.2, 0.3, 0.5, 1.0};

  // By place: "all", "far" and "near".
  std::map<std::string, HeightErrors> plane_off, shift_off;
  std::array<ToldDeviations, kToldEdges.size()> by_told;
  // Differences of the errors of a cell and its neighbour 1 m east or north: of all cells, and of
  // those far from what is tall.
  FineHistogram steps, steps_far;
  // Open ground that three photographs see, and those of its cells whose height is unknown.
  int64_t num_open = 0, num_unknown = 0;
  // Unknown cells in whose square of 5 by 5 more than 70 % of the others are known: holes in the
  // midst of known ground.
  int64_t num_scattered = 0;
  // Cells more than 2 m within landable ground; those of them that the roughness layer holds for
  // too rough, and those that are a hazard besides.
  int64_t num_landable = 0, num_looking_rough = 0, num_rough_hazards = 0;

  void Add(const HeightScores& other);
};

HeightScores ScoreHeights(const ElevationMap& map,
                          const HazardLayers& layers,
                          const Scenario& scenario,
                          const TruthMap& truth);

// Whole, so that worlds can be added up.
nlohmann::json ToJson(const HeightScores& scores);
HeightScores HeightScoresFromJson(const nlohmann::json& json);

}  // namespace freelsd
