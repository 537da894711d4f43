// Input: a seed. Output: a world, a half-finished survey over it, and photographs of any further
// leg.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "engine/next_look/next_look.h"
#include "tests/evaluation/engine_run.h"
#include "tests/evaluation/synthetic_flight.h"

namespace freelsd {

struct LookWorldOptions {
  // The survey has legs to the north and to the south, side by side; the western half is flown.
  int num_survey_legs = 6;
  double survey_leg_m = 180.0;
  double leg_spacing_m = 60.0;
  double frame_spacing_m = 30.0;
  double height_m = 100.0;
  // Of a leg that is flown after the survey. The ends of all of them lie in the survey, widened by
  // this margin.
  double look_leg_m = 150.0;
  double margin_m = 30.0;
  std::string aircraft = "both";
};

class LookWorld {
 public:
  LookWorld(uint64_t seed, const LookWorldOptions& options);

  // World, aircraft and rig; exposures and frames are empty.
  const Scenario& scenario() const { return scenario_; }
  const Box& area() const { return area_; }
  const std::vector<Frame>& survey() const { return survey_; }
  // Photographs of a leg. The ids of legs after the survey begin at num_survey_legs.
  std::vector<Frame> Photograph(const SyntheticLeg& leg) const;
  // Both ends in the area; evenly drawn by `number`.
  SyntheticLeg RandomLeg(int number) const;

 private:
  SyntheticLeg SurveyLeg(int number, double length_m) const;

  uint64_t seed_;
  LookWorldOptions options_;
  Scenario scenario_;
  Box area_;
  std::vector<Frame> survey_;
};

}  // namespace freelsd
