// Input: photographed passes whose truth is known. Output: the weights of EvidenceOf, which tells
// things from other changes.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "engine/watch/candidates.h"

namespace freelsd {

// Cues of a candidate.
struct CueSample {
  std::array<double, kNumCues> cues{};
  // At a new thing; those of quiet passes are not. Other candidates of passes with events are left
  // out: they may be shadows of things.
  bool is_thing = false;
  // Candidates of one photograph are often the same thing.
  double weight = 1.0;
};
std::vector<CueSample> SamplesOf(const std::string& folder, const WatchOptions& options);

// Logistic regression by Newton's method.
std::array<double, kNumCues> FitWeights(const std::vector<CueSample>& samples);

// The weights, and how well they divide the samples.
std::string CueReport(const std::vector<CueSample>& samples);

}  // namespace freelsd
