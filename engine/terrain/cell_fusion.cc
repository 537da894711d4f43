#include "engine/terrain/cell_fusion.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <tuple>

namespace freelsd {
namespace {

// Ratio of standard deviation to median absolute deviation, normal distribution.
constexpr double kSigmaPerMedianDeviation = 1.4826;

void SortByValue(std::vector<CellSummary>& summaries) {
  std::sort(summaries.begin(), summaries.end(), [](const CellSummary& a, const CellSummary& b) {
    return std::tie(a.mean, a.standard_deviation, a.num_points, a.upper, a.firm_upper) <
           std::tie(b.mean, b.standard_deviation, b.num_points, b.upper, b.firm_upper);
  });
}

// Pairs with too few points in the cell count only if no pair has enough.
void DropWeak(std::vector<CellSummary>& summaries, int min_num_points) {
  const auto is_weak = [min_num_points](const CellSummary& summary) {
    return summary.num_points < static_cast<uint32_t>(min_num_points);
  };
  if (!std::all_of(summaries.begin(), summaries.end(), is_weak)) std::erase_if(summaries, is_weak);
}

struct Center {
  double median = 0.0;
  double spread = 0.0;
};

// An even number of pairs has its centre midway between the two middle ones. Then two contradicting
// pairs are both far from it, and neither counts as the outlier.
Center CenterOf(const std::vector<CellSummary>& sorted) {
  const size_t low = (sorted.size() - 1) / 2, high = sorted.size() / 2;
  Center center;
  center.median = 0.5 * (sorted[low].mean + sorted[high].mean);
  const auto deviation = [&](const CellSummary& summary) {
    return std::abs(summary.mean - center.median);
  };
  if (sorted.size() <= 2) {
    center.spread =
        kSigmaPerMedianDeviation * 0.5 * (deviation(sorted.front()) + deviation(sorted.back()));
    return center;
  }
  std::vector<double> deviations;
  deviations.reserve(sorted.size());
  for (const CellSummary& summary : sorted) deviations.push_back(deviation(summary));
  std::sort(deviations.begin(), deviations.end());
  center.spread = kSigmaPerMedianDeviation * (0.5 * (deviations[low] + deviations[high]));
  return center;
}

// Highest value that one pair saw with enough points, or that two pairs saw. Mismatches may
// coincide in one cell of one pair, but not at one height in two pairs.
class UpperHeight {
 public:
  void Add(const CellSummary& summary) {
    firm_ = std::max(firm_, summary.firm_upper);
    second_ = std::max(second_, std::min(first_, summary.upper));
    first_ = std::max(first_, summary.upper);
  }
  double Height() const { return std::max(firm_, second_); }

 private:
  static constexpr float kLowest = std::numeric_limits<float>::lowest();
  float firm_ = kLowest, first_ = kLowest, second_ = kLowest;
};

FusedCell WeightedMean(const std::vector<CellSummary>& inliers) {
  double weights = 0.0, heights = 0.0;
  FusedCell fused;
  for (const CellSummary& summary : inliers) {
    const double weight = 1.0 / std::pow(summary.standard_deviation, 2);
    weights += weight;
    heights += weight * (summary.mean - inliers.front().mean);
    fused.num_points += summary.num_points;
  }
  fused.elevation = inliers.front().mean + heights / weights;
  double chi_squared = 0.0;
  for (const CellSummary& summary : inliers) {
    chi_squared += std::pow((summary.mean - fused.elevation) / summary.standard_deviation, 2);
  }
  // Pairs that disagree by more than their deviations allow widen the result (Birge 1932).
  const double num_free = std::max<double>(1.0, static_cast<double>(inliers.size()) - 1.0);
  fused.standard_deviation = std::sqrt(std::max(1.0, chi_squared / num_free) / weights);
  return fused;
}

}  // namespace

std::optional<FusedCell> FuseCell(std::vector<CellSummary> summaries,
                                  const TerrainOptions& options) {
  if (summaries.empty()) return std::nullopt;
  DropWeak(summaries, options.min_num_points);
  SortByValue(summaries);
  const Center center = CenterOf(summaries);
  const auto is_inlier = [&](const CellSummary& summary) {
    const double deviation = std::hypot(center.spread, summary.standard_deviation);
    return std::abs(summary.mean - center.median) <= options.outlier_sigma * deviation;
  };
  UpperHeight upper;
  bool has_inlier = false;
  for (const CellSummary& summary : summaries) {
    const bool has_support = summary.num_points >= static_cast<uint32_t>(options.min_num_points);
    const bool agrees = is_inlier(summary);
    has_inlier = has_inlier || agrees;
    if (agrees || has_support) upper.Add(summary);
  }
  if (has_inlier) std::erase_if(summaries, std::not_fn(is_inlier));
  FusedCell fused = WeightedMean(summaries);
  fused.upper = std::max(upper.Height(), fused.elevation);
  if (fused.num_points < options.min_num_points) return std::nullopt;
  return fused;
}

}  // namespace freelsd
