#include "tests/evaluation/kinds/kind_fit.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace freelsd {
namespace {

// A group weighs by the root of its number of cells of grass or of other ground, the smaller one,
// but no more than this: neighbouring cells err together.
constexpr double kMaxGroupWeight = 100.0;

size_t IndexOf(const std::vector<std::string>& names, const std::string& name) {
  return static_cast<size_t>(std::find(names.begin(), names.end(), name) - names.begin());
}

// Percentiles of a cue in a group, so that every group counts the same.
std::vector<float> QuantilesOf(const std::vector<KindCells>& all,
                               const std::string& group,
                               size_t cue) {
  std::vector<float> values, quantiles;
  for (const KindCells& cells : all) {
    if (cells.group != group) continue;
    for (const KindCell& cell : cells.cells) {
      if (!std::isnan(cell.cues[cue])) values.push_back(cell.cues[cue]);
    }
  }
  if (values.empty()) return quantiles;
  std::sort(values.begin(), values.end());
  for (size_t i = 0; i < 101; ++i) quantiles.push_back(values[i * (values.size() - 1) / 100]);
  return quantiles;
}

using Entries = std::vector<std::pair<Eigen::Index, double>>;

// Adds one row to the lower half of the Hessian and to the gradient.
void AddRow(const Entries& entries,
            double rest,
            double curvature,
            Eigen::MatrixXd& hessian,
            Eigen::VectorXd& gradient) {
  for (size_t i = 0; i < entries.size(); ++i) {
    gradient[entries[i].first] += rest * entries[i].second;
    const double part = curvature * entries[i].second;
    for (size_t j = 0; j <= i; ++j) {
      hessian(entries[i].first, entries[j].first) += part * entries[j].second;
    }
  }
}

double Logistic(double score) { return 1.0 / (1.0 + std::exp(-score)); }

}  // namespace

KindProblem::KindProblem(const std::vector<KindCells>& all, const KindFitOptions& options)
    : options_(options) {
  for (const KindCells& cells : all) {
    if (IndexOf(groups_, cells.group) == groups_.size()) groups_.push_back(cells.group);
  }
  std::sort(groups_.begin(), groups_.end());
  PlaceKnots(all);
  AddRows(all);
  Weigh();
}

void KindProblem::PlaceKnots(const std::vector<KindCells>& all) {
  for (size_t cue = 0; cue < kNumCues; ++cue) {
    std::vector<float> quantiles;
    for (const std::string& group : groups_) {
      const std::vector<float> of_group = QuantilesOf(all, group, cue);
      quantiles.insert(quantiles.end(), of_group.begin(), of_group.end());
    }
    std::sort(quantiles.begin(), quantiles.end());
    std::vector<float>& knots = knots_[cue];
    for (size_t i = 0; i < options_.num_knots && !quantiles.empty(); ++i) {
      const double share =
          0.02 + 0.96 * static_cast<double>(i) / static_cast<double>(options_.num_knots - 1);
      const float knot =
          quantiles[static_cast<size_t>(share * static_cast<double>(quantiles.size() - 1))];
      if (knots.empty() || knot > knots.back() + 1e-6f) knots.push_back(knot);
    }
    if (knots.size() < 2) knots = {0.0f, 1.0f};
    first_column_[cue] = static_cast<uint16_t>(num_columns_);
    num_columns_ += static_cast<Eigen::Index>(knots.size()) + 1;
  }
  ++num_columns_;
}

void KindProblem::AddRows(const std::vector<KindCells>& all) {
  for (const KindCells& cells : all) {
    for (const KindCell& cell : cells.cells) {
      Row row{IndexOf(groups_, cells.group),
              cell.kind,
              cell.is_fit > 0.5f,
              std::isnan(cell.is_fit),
              0.0,
              cell.weight,
              {},
              {}};
      for (size_t cue = 0; cue < kNumCues; ++cue) {
        const std::vector<float>& knots = knots_[cue];
        const float value = cell.cues[cue];
        size_t column = knots.size();
        if (!std::isnan(value)) {
          const float clamped = std::clamp(value, knots.front(), knots.back());
          const auto above = std::upper_bound(knots.begin(), knots.end() - 1, clamped);
          column = static_cast<size_t>(above - knots.begin()) - 1;
          row.next_share[cue] = (clamped - knots[column]) / (knots[column + 1] - knots[column]);
        }
        row.column[cue] = static_cast<uint16_t>(first_column_[cue] + column);
      }
      rows_.push_back(std::move(row));
    }
  }
}

// Within other ground a kind weighs by the root of its number of cells.
void KindProblem::Weigh() {
  std::map<std::pair<size_t, std::string>, double> num_cells;
  for (const Row& row : rows_) num_cells[{row.group, row.kind}] += row.num_cells;
  std::map<std::pair<size_t, bool>, double> sums, areas;
  for (Row& row : rows_) {
    if (row.is_only_reported) continue;
    const double num = num_cells[{row.group, row.kind}];
    row.weight = row.is_fit ? row.num_cells : row.num_cells / std::sqrt(num);
    sums[{row.group, row.is_fit}] += row.weight;
    areas[{row.group, row.is_fit}] += row.num_cells;
  }
  for (size_t group = 0; group < groups_.size(); ++group) {
    const double area = std::min(areas[{group, true}], areas[{group, false}]);
    group_weights_.push_back(std::min(kMaxGroupWeight, std::sqrt(area)));
  }
  for (Row& row : rows_) {
    if (row.weight <= 0.0) continue;
    row.weight *= 0.5 * group_weights_[row.group] / sums[{row.group, row.is_fit}];
  }
}

double KindProblem::ScoreOf(const Row& row,
                            const CueSet& cues,
                            const Eigen::VectorXd& coefficients) const {
  double score = coefficients[num_columns_ - 1];
  for (size_t cue = 0; cue < kNumCues; ++cue) {
    if (!cues[cue]) continue;
    const double share = row.next_share[cue];
    score += (1.0 - share) * coefficients[row.column[cue]];
    if (share > 0.0) score += share * coefficients[row.column[cue] + 1];
  }
  return score;
}

Eigen::VectorXd KindProblem::Fit(const CueSet& cues,
                                 std::optional<size_t> left_out,
                                 const Eigen::VectorXd& start,
                                 int num_steps) const {
  Eigen::VectorXd coefficients = start;
  Entries entries;
  for (int step = 0; step < num_steps; ++step) {
    Eigen::MatrixXd hessian = Eigen::MatrixXd::Identity(num_columns_, num_columns_);
    hessian *= options_.ridge;
    Eigen::VectorXd gradient = -options_.ridge * coefficients;
    hessian(num_columns_ - 1, num_columns_ - 1) = 1e-3;
    gradient[num_columns_ - 1] = 0.0;
    for (const Row& row : rows_) {
      if (row.weight <= 0.0 || row.group == left_out) continue;
      entries.assign(1, {num_columns_ - 1, 1.0});
      for (size_t cue = 0; cue < kNumCues; ++cue) {
        if (!cues[cue]) continue;
        const double share = row.next_share[cue];
        entries.emplace_back(row.column[cue], 1.0 - share);
        if (share > 0.0) entries.emplace_back(row.column[cue] + 1, share);
      }
      const double probability = Logistic(ScoreOf(row, cues, coefficients));
      const double rest = row.weight * ((row.is_fit ? 1.0 : 0.0) - probability);
      const double curvature = row.weight * std::max(1e-4, probability * (1.0 - probability));
      AddRow(entries, rest, curvature, hessian, gradient);
    }
    coefficients += hessian.selfadjointView<Eigen::Lower>().ldlt().solve(gradient);
  }
  return coefficients;
}

KindModel KindProblem::ModelOf(const CueSet& cues, const Eigen::VectorXd& coefficients) const {
  KindModel model;
  model.offset = static_cast<float>(coefficients[num_columns_ - 1]);
  for (size_t cue = 0; cue < kNumCues; ++cue) {
    if (!cues[cue]) continue;
    CueTerm term{static_cast<Cue>(cue), knots_[cue], {}, 0.0f};
    for (size_t i = 0; i < knots_[cue].size(); ++i) {
      term.log_odds.push_back(
          static_cast<float>(coefficients[first_column_[cue] + static_cast<Eigen::Index>(i)]));
    }
    term.unknown_log_odds = static_cast<float>(
        coefficients[first_column_[cue] + static_cast<Eigen::Index>(knots_[cue].size())]);
    model.terms.push_back(std::move(term));
  }
  return model;
}

}  // namespace freelsd
