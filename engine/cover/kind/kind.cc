#include "engine/cover/kind/kind.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace freelsd {

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

cv::Mat1f KindScores(const CueInput& input, const CoverOptions& options, const KindModel& model) {
  float unknown = model.offset;
  for (const CueTerm& term : model.terms) unknown += term.unknown_log_odds;
  cv::Mat1f scores(input.map.elevation.size(), unknown);
  VisitCues(input, options, [&](Cue cue, const cv::Mat1f& values) {
    const auto term = std::find_if(model.terms.begin(),
                                   model.terms.end(),
                                   [&](const CueTerm& each) { return each.cue == cue; });
    if (term == model.terms.end()) return;
    for (int row = 0; row < scores.rows; ++row) {
      for (int col = 0; col < scores.cols; ++col) {
        scores(row, col) += term->At(values(row, col)) - term->unknown_log_odds;
      }
    }
  });
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
                           const KindModel& model) {
  cv::Mat1f grass = KindScores(input, options, model);
  std::transform(grass.begin(), grass.end(), grass.begin(), [&](float score) {
    return std::isnan(score) ? score : model.Probability(score);
  });
  return grass;
}

}  // namespace freelsd
