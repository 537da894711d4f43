// Input: cues of every map cell. Output: the probability that it is grass fit to land on.
#pragma once

#include <functional>
#include <vector>

#include "engine/cover/kind/cues.h"

namespace freelsd {

// What one cue adds to the log-odds: linear between knots, constant beyond the first and the last.
struct CueTerm {
  Cue cue = Cue::kViewLogOdds;
  // Ascending; of the same length.
  std::vector<float> knots;
  std::vector<float> log_odds;
  // Added where the cue is unknown.
  float unknown_log_odds = 0.0f;

  float At(float value) const;
};

// What ground of places that the model had not seen earned from this score on, where half of all
// ground was grass.
struct EarnedStep {
  float min_score = 0.0f;
  float probability = 0.0f;
};

struct KindModel {
  float offset = 0.0f;
  std::vector<CueTerm> terms;
  // Ascending in both. Below the first step the probability is 0.
  std::vector<EarnedStep> earned;

  // Of a score, which is the offset and the sum of all terms.
  float Probability(float score) const;
};

// Written by freelsd-kinds (kind_table.cc).
const KindModel& ShippedKindModel();

// Called for the offset ("prior") and for each term: what it adds, one value per map cell.
using TermVisitor = std::function<void(const char* name, const cv::Mat1f& log_odds)>;

// Sum of offset and terms for each map cell; NaN where the map is unseen.
cv::Mat1f KindScores(const CueInput& input,
                     const CoverOptions& options,
                     const KindModel& model,
                     const TermVisitor& visit = {});
// NaN where the map is unseen.
cv::Mat1f GrassProbability(const CueInput& input,
                           const CoverOptions& options,
                           const KindModel& model,
                           const TermVisitor& visit = {});

}  // namespace freelsd
