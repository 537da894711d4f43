#include "tests/evaluation/kinds/kind_scores.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace freelsd {
namespace {

constexpr int kNumSteps = 12;
// Operating points.
constexpr double kFirstScore = -4.0;
constexpr double kLastScore = 8.0;
constexpr double kStepWidth = 0.25;
// Weight of both kinds of ground together that is added to each step: few cells earn little.
constexpr double kPriorWeight = 1.0;

double LossOf(double score, bool is_fit) {
  const double margin = is_fit ? score : -score;
  return margin > 0.0 ? std::log1p(std::exp(-margin)) : -margin + std::log1p(std::exp(margin));
}

std::vector<size_t> ByScore(const KindProblem& problem,
                            const std::vector<double>& scores,
                            size_t group) {
  std::vector<size_t> order;
  for (size_t i = 0; i < scores.size(); ++i) {
    const KindProblem::Row& row = problem.rows()[i];
    if (row.group == group && row.weight > 0.0) order.push_back(i);
  }
  std::sort(order.begin(), order.end(), [&](size_t a, size_t b) { return scores[a] < scores[b]; });
  return order;
}

GroupScore ScoreGroup(const KindProblem& problem,
                      const std::vector<double>& scores,
                      size_t group,
                      double min_score) {
  GroupScore result;
  double sum = 0.0, other_below = 0.0, pairs = 0.0, fit = 0.0, other = 0.0;
  double fit_cells = 0.0, other_cells = 0.0, called_fit = 0.0, called_other = 0.0;
  for (const size_t i : ByScore(problem, scores, group)) {
    const KindProblem::Row& row = problem.rows()[i];
    result.log_loss += row.weight * LossOf(scores[i], row.is_fit);
    sum += row.weight;
    (row.is_fit ? fit : other) += row.weight;
    if (row.is_fit) pairs += row.weight * other_below;
    if (!row.is_fit) other_below += row.weight;
    (row.is_fit ? fit_cells : other_cells) += row.num_cells;
    if (scores[i] >= min_score) (row.is_fit ? called_fit : called_other) += row.num_cells;
  }
  result.log_loss /= sum;
  result.auc = pairs / (fit * other);
  result.false_share = called_other / other_cells;
  result.recall = called_fit / fit_cells;
  result.false_among_called = called_other / std::max(1.0, called_other + called_fit);
  return result;
}

// Log-odds of grass as a line of the score.
struct Calibration {
  double slope = 1.0;
  double offset = 0.0;
};

// Of recorded photographs, by Newton's method.
Calibration Calibrate(const KindProblem& problem, const std::vector<double>& scores) {
  Eigen::Vector2d line(1.0, 0.0);
  for (int step = 0; step < kNumSteps; ++step) {
    Eigen::Matrix2d hessian = 1e-6 * Eigen::Matrix2d::Identity();
    Eigen::Vector2d gradient = Eigen::Vector2d::Zero();
    for (size_t i = 0; i < scores.size(); ++i) {
      const KindProblem::Row& row = problem.rows()[i];
      if (row.weight <= 0.0 || !problem.IsRecorded(row.group)) continue;
      const Eigen::Vector2d terms(scores[i], 1.0);
      const double probability = 1.0 / (1.0 + std::exp(-line.dot(terms)));
      gradient += row.weight * ((row.is_fit ? 1.0 : 0.0) - probability) * terms;
      hessian += row.weight * probability * (1.0 - probability) * terms * terms.transpose();
    }
    line += hessian.ldlt().solve(gradient);
  }
  return {line[0], line[1]};
}

}  // namespace

std::vector<Eigen::VectorXd> FitsLeftOut(const KindProblem& problem, const CueSet& cues) {
  std::vector<Eigen::VectorXd> fits;
  for (size_t group = 0; group < problem.groups().size(); ++group) {
    fits.push_back(
        problem.Fit(cues, group, Eigen::VectorXd::Zero(problem.num_columns()), kNumSteps));
  }
  return fits;
}

std::vector<double> ScoresFrom(const KindProblem& problem,
                               const CueSet& cues,
                               const std::vector<Eigen::VectorXd>& start,
                               int num_steps) {
  std::vector<double> scores(problem.rows().size());
  for (size_t group = 0; group < problem.groups().size(); ++group) {
    const Eigen::VectorXd fit = problem.Fit(cues, group, start[group], num_steps);
    for (size_t i = 0; i < scores.size(); ++i) {
      const KindProblem::Row& row = problem.rows()[i];
      if (row.group == group) scores[i] = problem.ScoreOf(row, cues, fit);
    }
  }
  return scores;
}

std::vector<double> ScoresLeftOut(const KindProblem& problem, const CueSet& cues) {
  return ScoresFrom(problem, cues, FitsLeftOut(problem, cues), 0);
}

std::vector<GroupScore> ScoreGroups(const KindProblem& problem,
                                    const std::vector<double>& scores,
                                    double min_score) {
  std::vector<GroupScore> results;
  for (size_t group = 0; group < problem.groups().size(); ++group) {
    results.push_back(ScoreGroup(problem, scores, group, min_score));
  }
  return results;
}

std::vector<EarnedStep> EarnedSteps(const KindProblem& problem, const std::vector<double>& scores) {
  const Calibration calibration = Calibrate(problem, scores);
  std::vector<EarnedStep> earned;
  for (double least = kFirstScore; least <= kLastScore; least += kStepWidth) {
    double fit = 0.5 * kPriorWeight, all = kPriorWeight;
    for (size_t i = 0; i < scores.size(); ++i) {
      const KindProblem::Row& row = problem.rows()[i];
      if (scores[i] < least || !problem.IsRecorded(row.group)) continue;
      all += row.weight;
      if (row.is_fit) fit += row.weight;
    }
    const double calibrated =
        1.0 / (1.0 + std::exp(-calibration.slope * least - calibration.offset));
    const auto probability = static_cast<float>(std::min(calibrated, fit / all));
    if (!earned.empty() && probability <= earned.back().probability) continue;
    earned.push_back({static_cast<float>(least), probability});
  }
  return earned;
}

}  // namespace freelsd
