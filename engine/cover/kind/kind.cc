#include "engine/cover/kind/kind.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace freelsd {
namespace {

cv::Mat1f AddedBy(const CueTerm& term, const cv::Mat1f& values) {
  cv::Mat1f added(values.size());
  std::transform(
      values.begin(), values.end(), added.begin(), [&](float value) { return term.At(value); });
  return added;
}

}  // namespace

float CueTerm::At(float value) const {
  if (std::isnan(value)) return unknown_log_odds;
  const auto above = std::upper_bound(knots.begin(), knots.end(), value);
  if (above == knots.begin()) return log_odds.front();
  if (above == knots.end()) return log_odds.back();
  const auto i = static_cast<size_t>(above - knots.begin());
  const float way = (value - knots[i - 1]) / (knots[i] - knots[i - 1]);
  return log_odds[i - 1] + way * (log_odds[i] - log_odds[i - 1]);
}

float KindModel::Probability(float score) const {
  const auto above =
      std::upper_bound(earned.begin(), earned.end(), score, [](float value, const auto& step) {
        return value < step.min_score;
      });
  return above == earned.begin() ? 0.0f : (above - 1)->probability;
}

cv::Mat1f KindScores(const CueInput& input,
                     const CoverOptions& options,
                     const KindModel& model,
                     const TermVisitor& visit) {
  const cv::Size size = input.map.elevation.size();
  float unknown = model.offset;
  for (const CueTerm& term : model.terms) unknown += term.unknown_log_odds;
  cv::Mat1f scores(size, unknown);
  if (visit) visit("prior", cv::Mat1f(size, model.offset));
  std::vector<bool> is_measured(model.terms.size(), false);
  VisitCues(input, options, [&](Cue cue, const cv::Mat1f& values) {
    const auto term = std::find_if(model.terms.begin(),
                                   model.terms.end(),
                                   [&](const CueTerm& each) { return each.cue == cue; });
    if (term == model.terms.end()) return;
    is_measured[static_cast<size_t>(term - model.terms.begin())] = true;
    if (visit) visit(kCueNames.at(static_cast<size_t>(cue)), AddedBy(*term, values));
    for (int row = 0; row < scores.rows; ++row) {
      for (int col = 0; col < scores.cols; ++col) {
        scores(row, col) += term->At(values(row, col)) - term->unknown_log_odds;
      }
    }
  });
  for (size_t i = 0; visit && i < model.terms.size(); ++i) {
    const CueTerm& term = model.terms[i];
    if (is_measured[i]) continue;
    visit(kCueNames.at(static_cast<size_t>(term.cue)), cv::Mat1f(size, term.unknown_log_odds));
  }
  for (int row = 0; row < scores.rows; ++row) {
    for (int col = 0; col < scores.cols; ++col) {
      if (!input.map.IsSeen(row, col)) {
        scores(row, col) = std::numeric_limits<float>::quiet_NaN();
      }
    }
  }
  return scores;
}

cv::Mat1f GrassProbability(const CueInput& input,
                           const CoverOptions& options,
                           const KindModel& model,
                           const TermVisitor& visit) {
  cv::Mat1f grass = KindScores(input, options, model, visit);
  std::transform(grass.begin(), grass.end(), grass.begin(), [&](float score) {
    return std::isnan(score) ? score : model.Probability(score);
  });
  return grass;
}

}  // namespace freelsd
