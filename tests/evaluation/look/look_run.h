// Input: a seed. Output: what the suggested legs gained over that world, and what random legs of
// the same length did, as JSON.
#pragma once

#include <cstdint>
#include <string>

#include <nlohmann/json.hpp>

#include "engine/classification/classification.h"
#include "tests/evaluation/look/look_world.h"
#include "tests/evaluation/truth_map.h"

namespace freelsd {

struct LookRunOptions {
  LookWorldOptions world;
  NextLookOptions look;
  // Random legs that are photographed, and pairs of them that are flown.
  int num_random_legs = 8;
  int num_random_pairs = 20;
  // Folder for pictures; "" for none.
  std::string pictures;
};

// {seed, aircraft, before, suggested, random: [...]}; each outcome is {landing_value,
// num_landable, num_unverified, num_false_safe, num_only_thin}, and `suggested` has expected_gain
// besides.
nlohmann::json RunLook(uint64_t seed, const LookRunOptions& options, const Classifier& classifier);

// What the engine's sites are worth in truth: 1 for each landable one, unverified_value for each
// unverified one, nothing for one that is false safe.
nlohmann::json OutcomeOf(const EngineRun& run,
                         const Scenario& scenario,
                         const TruthMap& truth,
                         double unverified_value);

}  // namespace freelsd
