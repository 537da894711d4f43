#include "engine/terrain/cell_fusion.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <tuple>

namespace freelsd {
namespace {

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

// A run of the sorted summaries.
struct Run {
  size_t begin = 0;
  size_t size = 0;
};

double Width(const std::vector<CellSummary>& sorted, const Run& run) {
  return sorted[run.begin + run.size - 1].mean - sorted[run.begin].mean;
}

// The largest set of pairs whose means agree; the narrowest one of equal sets.
Run LargestAgreement(const std::vector<CellSummary>& sorted, double tolerance_m, double sigma) {
  Run best{0, 1};
  for (size_t first = 0; first < sorted.size(); ++first) {
    size_t end = first + 1;
    while (end < sorted.size() &&
           sorted[end].mean - sorted[first].mean <=
               std::max(tolerance_m,
                        sigma * std::hypot(sorted[first].standard_deviation,
                                           sorted[end].standard_deviation))) {
      ++end;
    }
    const Run run{first, end - first};
    if (run.size > best.size ||
        (run.size == best.size && Width(sorted, run) < Width(sorted, best))) {
      best = run;
    }
  }
  return best;
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

// Pairs of overlapping photographs share their errors: of n pairs, about (n + 1) / 2 are
// independent.
double NumIndependent(size_t num_pairs) { return 0.5 * (static_cast<double>(num_pairs) + 1.0); }
// Fewer pairs do not check each other.
constexpr size_t kMinNumChecked = 3;

// Weighted mean of pairs that agree. Its deviation follows from what they differ by, but is at
// least what they tell themselves.
FusedCell FusedFrom(std::span<const CellSummary> pairs, double unchecked_factor) {
  double weights = 0.0, heights = 0.0, told = 0.0;
  FusedCell fused;
  for (const CellSummary& pair : pairs) {
    const double variance = std::pow(pair.standard_deviation, 2);
    weights += 1.0 / variance;
    heights += (pair.mean - pairs.front().mean) / variance;
    told += variance;
    fused.num_points += pair.num_points;
  }
  fused.elevation = pairs.front().mean + heights / weights;
  double spread = 0.0;
  for (const CellSummary& pair : pairs) spread += std::pow(pair.mean - fused.elevation, 2);
  const auto num = static_cast<double>(pairs.size());
  const double of_one = std::max(spread / std::max(num - 1.0, 1.0), told / num);
  fused.standard_deviation = std::sqrt(of_one / NumIndependent(pairs.size()));
  if (pairs.size() < kMinNumChecked) fused.standard_deviation *= unchecked_factor;
  return fused;
}

}  // namespace

std::optional<FusedCell> FuseCell(std::vector<CellSummary> summaries,
                                  const TerrainOptions& options) {
  if (summaries.empty()) return std::nullopt;
  DropWeak(summaries, options.min_num_points);
  SortByValue(summaries);
  const Run run =
      LargestAgreement(summaries, options.max_pair_disagreement_m, options.pair_agreement_sigma);
  const bool is_majority = 2 * run.size > summaries.size();
  if (!is_majority) return std::nullopt;
  FusedCell fused =
      FusedFrom(std::span(summaries).subspan(run.begin, run.size), options.unchecked_factor);
  if (fused.num_points < options.min_num_points) return std::nullopt;
  // Of all pairs: those that see a thin thing are few.
  UpperHeight upper;
  for (const CellSummary& summary : summaries) upper.Add(summary);
  fused.upper = std::max(upper.Height(), fused.elevation);
  return fused;
}

}  // namespace freelsd
