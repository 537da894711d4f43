#include "engine/heights/likelihood.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <opencv2/imgproc.hpp>

#include "engine/heights/likelihood_table.h"

namespace freelsd {
namespace {

constexpr float kNotTold = std::numeric_limits<float>::quiet_NaN();

// Error of a height with an infinitely sharp peak: poses that differ from view to view.
constexpr double kLeastDeviationM = 0.1;
// Upper edges of all bins but the last.
constexpr std::array<double, kNumViewBins - 1> kViewEdges{2.5, 3.5, 5.5};
constexpr std::array<double, kNumContrastBins - 1> kContrastEdges{0.05, 0.12};
constexpr std::array<double, kNumDisagreementBins - 1> kDisagreementEdges{
    -8.0, -7.0, -6.25, -5.5, -4.75, -4.0, -3.25};
constexpr std::array<double, kNumGainBins - 1> kGainEdges{0.3, 1.0, 2.0};

template <size_t num_edges>
int BinAmong(const std::array<double, num_edges>& edges, double value) {
  return static_cast<int>(std::upper_bound(edges.begin(), edges.end(), value) - edges.begin());
}

CannotTell CauseAt(const HeightEvidence& evidence,
                   const HeightsOptions& options,
                   const cv::Point& cell) {
  if (evidence.num_views(cell) < static_cast<float>(options.min_num_views)) {
    return CannotTell::kTooFewViews;
  }
  if (evidence.baseline_ratio(cell) < options.min_baseline_ratio) {
    return CannotTell::kTooLittleParallax;
  }
  if (!(evidence.contrast(cell) >= options.min_contrast)) return CannotTell::kNoContrast;
  const bool stands_out = evidence.correlation(cell) >= options.min_correlation &&
                          std::isfinite(evidence.peak_width(cell));
  return stands_out ? CannotTell::kNothing : CannotTell::kNoHeightStandsOut;
}

double ThingProbability(const TableBin& bin, const HeightsOptions& options) {
  const double prior = options.thing_prior_probability;
  const double odds = prior / (1.0 - prior) * std::exp(ThingLogRatio(bin));
  return odds / (1.0 + odds);
}

// Whether the views agree at a height of that gain as they do on open ground. Twigs fit a little
// better at many heights and well at none.
bool IsExplained(const HeightEvidence& evidence,
                 const HeightsOptions& options,
                 const cv::Point& cell,
                 float gain) {
  auto bin = BinOf(evidence, cell);
  if (!bin) return false;
  bin->disagreement = BinAmong(kDisagreementEdges, evidence.disagreement(cell) - gain);
  bin->gain = 0;
  return ThingProbability(*bin, options) <= options.max_thing_probability;
}

// What stands higher than was searched is left to the pairs.
bool IsBeyondSearch(const ElevationMap& proposal,
                    const HeightEvidence& evidence,
                    const HeightsOptions& options,
                    const cv::Point& cell) {
  return proposal.elevation(cell) - evidence.proposal(cell) >
         options.search_range_m - options.min_thing_height_m;
}

// Highest height over the ground that the evidence speaks for; nothing if none does.
std::optional<float> HighestMode(const HeightEvidence& evidence,
                                 const HeightsOptions& options,
                                 const cv::Point& cell,
                                 float proposed_upper) {
  std::optional<float> mode;
  const float gain = evidence.gain(cell), proposed_gain = evidence.proposed_gain(cell);
  if (gain >= options.min_mode_gain && IsExplained(evidence, options, cell, gain)) {
    mode = evidence.gain_height(cell);
  }
  const bool is_above =
      proposed_upper - evidence.ground(cell) >= static_cast<float>(options.min_thing_height_m);
  if (is_above && proposed_gain >= options.min_proposed_gain &&
      IsExplained(evidence, options, cell, proposed_gain)) {
    mode = std::max(mode.value_or(proposed_upper), proposed_upper);
  }
  return mode;
}

struct CellJudgement {
  CannotTell cannot_tell = CannotTell::kNothing;
  float ground = kNotTold, upper = kNotTold, deviation = kNotTold, thing_probability = kNotTold;
};

CellJudgement JudgeCell(const ElevationMap& proposal,
                        const HeightEvidence& evidence,
                        const HeightsOptions& options,
                        const cv::Point& cell) {
  if (IsBeyondSearch(proposal, evidence, options, cell)) {
    return {CannotTell::kNothing,
            proposal.elevation(cell),
            proposal.upper(cell),
            proposal.standard_deviation(cell),
            1.0f};
  }
  CellJudgement judgement{CauseAt(evidence, options, cell),
                          evidence.ground(cell),
                          evidence.ground(cell),
                          static_cast<float>(DeviationOf(evidence.peak_width(cell)))};
  if (judgement.cannot_tell != CannotTell::kNothing) return judgement;
  const auto bin = BinOf(evidence, cell);
  const double probability = bin ? ThingProbability(*bin, options) : 1.0;
  judgement.thing_probability = static_cast<float>(probability);
  if (probability <= options.max_thing_probability) return judgement;
  const auto mode = HighestMode(evidence, options, cell, proposal.upper(cell));
  if (!mode) judgement.cannot_tell = CannotTell::kNoHeightStandsOut;
  judgement.upper = mode.value_or(judgement.upper);
  return judgement;
}

// Cells that can be told, and show nothing themselves, among cells with things: twigs are sparse.
cv::Mat1b AmongThings(const PhotographHeights& heights, const HeightsOptions& options) {
  constexpr int kSide = 3;
  const auto most = static_cast<float>(options.max_thing_probability);
  const cv::Mat1b has_thing = heights.thing_probability > most;
  cv::Mat1f num_things;
  cv::boxFilter(
      has_thing, num_things, CV_32F, {kSide, kSide}, {-1, -1}, false, cv::BORDER_CONSTANT);
  cv::Mat1b is_among = num_things >= 255.0 * options.min_num_thing_neighbours;
  is_among &= ~has_thing;
  return is_among & (heights.cannot_tell == static_cast<uint8_t>(CannotTell::kNothing));
}

}  // namespace

std::optional<TableBin> BinOf(const HeightEvidence& evidence, const cv::Point& cell) {
  const float contrast = evidence.contrast(cell), disagreement = evidence.disagreement(cell);
  if (!(contrast > 0.0f) || !std::isfinite(disagreement)) return std::nullopt;
  const float gain = std::max(evidence.gain(cell), evidence.proposed_gain(cell));
  return TableBin{BinAmong(kViewEdges, evidence.num_views(cell)),
                  BinAmong(kContrastEdges, contrast),
                  BinAmong(kDisagreementEdges, disagreement),
                  BinAmong(kGainEdges, gain)};
}

int IndexOf(const TableBin& bin) {
  const int views_contrast = bin.views * kNumContrastBins + bin.contrast;
  return (views_contrast * kNumDisagreementBins + bin.disagreement) * kNumGainBins + bin.gain;
}

double ThingLogRatio(const TableBin& bin) {
  return 0.1 * kThingLogRatio10[static_cast<size_t>(IndexOf(bin))];
}

double DeviationOf(double peak_width) { return std::hypot(kLeastDeviationM, peak_width); }

void Judge(const ElevationMap& proposal,
           const HeightsOptions& options,
           PhotographHeights& heights) {
  const HeightEvidence& evidence = heights.evidence;
  heights.ground = cv::Mat1f(evidence.ground.size(), kNotTold);
  heights.upper = heights.ground.clone();
  heights.standard_deviation = heights.ground.clone();
  heights.thing_probability = heights.ground.clone();
  heights.cannot_tell = cv::Mat1b(evidence.ground.size(), uint8_t{0});
  for (int row = 0; row < evidence.ground.rows; ++row) {
    for (int col = 0; col < evidence.ground.cols; ++col) {
      const CellJudgement cell = JudgeCell(proposal, evidence, options, {col, row});
      heights.cannot_tell(row, col) = static_cast<uint8_t>(cell.cannot_tell);
      heights.thing_probability(row, col) = cell.thing_probability;
      heights.ground(row, col) = cell.ground;
      heights.upper(row, col) = std::max(cell.upper, cell.ground);
      heights.standard_deviation(row, col) = cell.deviation;
    }
  }
  if (evidence.ground.empty()) return;
  heights.cannot_tell.setTo(static_cast<uint8_t>(CannotTell::kNoHeightStandsOut),
                            AmongThings(heights, options));
  const cv::Mat1b is_unknown = heights.cannot_tell != static_cast<uint8_t>(CannotTell::kNothing);
  for (cv::Mat1f* raster : {&heights.ground, &heights.upper, &heights.standard_deviation}) {
    raster->setTo(kNotTold, is_unknown);
  }
}

}  // namespace freelsd
