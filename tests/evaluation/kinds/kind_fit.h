// Input: cells of known kind, by group. Output: a model of the kind, fitted to all groups or with
// one left out. Logistic regression on cues that are piecewise linear, with an L2 penalty.
#pragma once

#include <bitset>
#include <optional>
#include <string>
#include <vector>

#include "engine/cover/kind/kind.h"
#include "tests/evaluation/kinds/kind_cells.h"

namespace freelsd {

using CueSet = std::bitset<kNumCues>;

struct KindFitOptions {
  // Knots of a cue stand at even quantiles of its values, with the same weight of every group.
  size_t num_knots = 6;
  // Penalty of the squared coefficients. A group weighs up to 100, half of it of grass.
  double ridge = 1.0;
};

class KindProblem {
 public:
  // Cells that are only reported are kept apart.
  KindProblem(const std::vector<KindCells>& all, const KindFitOptions& options);

  struct Row {
    size_t group = 0;
    std::string kind;
    bool is_fit = false;
    bool is_only_reported = false;
    // In the fit, where every group and both kinds of ground weigh the same.
    double weight = 0.0;
    // Number of cells that it stands for.
    double num_cells = 0.0;
    // Of each cue: the column of its knot, and the share of the next column.
    std::array<uint16_t, kNumCues> column{};
    std::array<float, kNumCues> next_share{};
  };

  const std::vector<std::string>& groups() const { return groups_; }
  const std::vector<Row>& rows() const { return rows_; }
  // Whether the group shows recorded photographs: all but painted worlds.
  bool IsRecorded(size_t group) const { return !groups_[group].starts_with("painted"); }
  double WeightOf(size_t group) const { return group_weights_[group]; }
  // Without one group; from the start on. One coefficient per column, the offset last.
  Eigen::VectorXd Fit(const CueSet& cues,
                      std::optional<size_t> left_out,
                      const Eigen::VectorXd& start,
                      int num_steps) const;
  double ScoreOf(const Row& row, const CueSet& cues, const Eigen::VectorXd& coefficients) const;
  Eigen::Index num_columns() const { return num_columns_; }
  // Without steps of earned probabilities.
  KindModel ModelOf(const CueSet& cues, const Eigen::VectorXd& coefficients) const;

 private:
  void PlaceKnots(const std::vector<KindCells>& all);
  void AddRows(const std::vector<KindCells>& all);
  void Weigh();

  KindFitOptions options_;
  std::vector<std::string> groups_;
  std::vector<double> group_weights_;
  std::array<std::vector<float>, kNumCues> knots_;
  std::array<uint16_t, kNumCues> first_column_{};
  Eigen::Index num_columns_ = 0;
  std::vector<Row> rows_;
};

}  // namespace freelsd
