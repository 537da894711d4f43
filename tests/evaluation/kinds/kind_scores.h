// Input: scores of cells of known kind. Output: how good they are, by group, and which probability
// they earn.
#pragma once

#include <string>
#include <vector>

#include "tests/evaluation/kinds/kind_fit.h"

namespace freelsd {

// Score of each row of the problem, by a model that did not see its group.
std::vector<double> ScoresLeftOut(const KindProblem& problem, const CueSet& cues);
// The same, quickly, beginning with fits of more cues: coefficients by group.
std::vector<double> ScoresFrom(const KindProblem& problem,
                               const CueSet& cues,
                               const std::vector<Eigen::VectorXd>& start,
                               int num_steps);
std::vector<Eigen::VectorXd> FitsLeftOut(const KindProblem& problem, const CueSet& cues);

struct GroupScore {
  double log_loss = 0.0;
  double auc = 0.0;
  // Of ground that is not fit, the share with at least that score; and the same of grass. By number
  // of cells.
  double false_share = 0.0;
  double recall = 0.0;
  // Of the cells with at least that score, the share that is not fit.
  double false_among_called = 0.0;
};
std::vector<GroupScore> ScoreGroups(const KindProblem& problem,
                                    const std::vector<double>& scores,
                                    double min_score);

// Rising steps from the scores of recorded photographs that were left out, where half of the ground
// is grass. A step's probability is that of its score, but no more than the share of grass in all
// ground with at least that score: this is what an operating point calls grass.
std::vector<EarnedStep> EarnedSteps(const KindProblem& problem, const std::vector<double>& scores);

}  // namespace freelsd
