// Input: the frontend's state of a flight, and what of the truth an engine is given. Output: its
// answer, as the pipeline would make it: how much each stage's error costs.
#pragma once

#include <string>
#include <vector>

#include "tests/evaluation/engine_run.h"
#include "tests/evaluation/synthetic_flight.h"
#include "tests/evaluation/truth_map.h"

namespace freelsd {

struct Given {
  // Before stereo and fusion.
  bool poses = false;
  // On the finished map: where meadow is, and nothing else.
  bool kinds = false;
  // On the finished map, wherever it or three photographs saw the ground: elevation and upper
  // heights, with a small deviation, and slope and roughness of them.
  bool heights = false;
  // Without a spread.
  bool wind = false;

  // Throws std::invalid_argument if a name is none of NamesOfGiven.
  static Given Of(const std::vector<std::string>& names);
};
std::vector<std::string> NamesOfGiven();

struct GivenTruth {
  Given given;
  const Scenario& scenario;
  const TruthMap& truth;
};

// As EvaluateSites does. All references must outlive the answer.
EvaluateFlight EvaluateGiven(const GivenTruth& truth, const Aircraft& aircraft);

}  // namespace freelsd
