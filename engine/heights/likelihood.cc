#include "engine/heights/likelihood.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace freelsd {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

CannotTell CauseAt(const HeightEvidence& evidence,
                   const HeightsOptions& options,
                   int row,
                   int col) {
  if (evidence.num_views(row, col) < static_cast<float>(options.min_num_views)) {
    return CannotTell::kTooFewViews;
  }
  if (evidence.baseline_ratio(row, col) < options.min_baseline_ratio) {
    return CannotTell::kTooLittleParallax;
  }
  if (!(evidence.contrast(row, col) >= options.min_contrast)) return CannotTell::kNoContrast;
  if (!(evidence.correlation(row, col) >= options.min_correlation)) {
    return CannotTell::kNoHeightStandsOut;
  }
  return std::isfinite(evidence.peak_width(row, col)) ? CannotTell::kNothing
                                                      : CannotTell::kNoHeightStandsOut;
}

}  // namespace

void Judge(const HeightsOptions& options, PhotographHeights& heights) {
  const HeightEvidence& evidence = heights.evidence;
  heights.ground = evidence.ground.clone();
  heights.upper = evidence.ground.clone();
  heights.standard_deviation = evidence.peak_width.clone();
  heights.thing_probability = cv::Mat1f(evidence.ground.size(), kNaN);
  heights.cannot_tell = cv::Mat1b(evidence.ground.size(), uint8_t{0});
  for (int row = 0; row < heights.ground.rows; ++row) {
    for (int col = 0; col < heights.ground.cols; ++col) {
      const CannotTell cause = CauseAt(evidence, options, row, col);
      heights.cannot_tell(row, col) = static_cast<uint8_t>(cause);
      if (cause == CannotTell::kNothing) continue;
      heights.ground(row, col) = heights.upper(row, col) = kNaN;
      heights.standard_deviation(row, col) = kNaN;
    }
  }
}

}  // namespace freelsd
