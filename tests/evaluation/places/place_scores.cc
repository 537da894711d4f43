#include "tests/evaluation/places/place_scores.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace freelsd {
namespace {

constexpr int kNumDraws = 1000;
constexpr double kLowQuantile = 0.025;
constexpr double kHighQuantile = 0.975;

Figure Ratio(double part, double whole) {
  return whole > 0.0 ? Figure(part / whole) : std::nullopt;
}

struct Counts {
  int num_right_grass = 0;
  int num_called = 0;
  int num_grass = 0;
};

Counts CountsOf(const JudgedPolygons& polygons, double min_grass_probability) {
  Counts counts;
  for (const JudgedPolygon& polygon : polygons) {
    const bool is_called = polygon.probability >= min_grass_probability;
    counts.num_called += is_called ? 1 : 0;
    counts.num_grass += polygon.is_grass ? 1 : 0;
    counts.num_right_grass += is_called && polygon.is_grass ? 1 : 0;
  }
  return counts;
}

// Nearest rank. `sorted` must not be empty.
double QuantileOf(const std::vector<double>& sorted, double quantile) {
  const double rank = std::ceil(quantile * static_cast<double>(sorted.size()));
  return sorted[static_cast<size_t>(std::max(rank, 1.0)) - 1];
}

}  // namespace

Figure ErrorOf(const JudgedPolygons& polygons, double min_grass_probability) {
  const Counts counts = CountsOf(polygons, min_grass_probability);
  return Ratio(counts.num_called + counts.num_grass - 2 * counts.num_right_grass,
               static_cast<double>(polygons.size()));
}

Figure PrecisionOf(const JudgedPolygons& polygons, double min_grass_probability) {
  const Counts counts = CountsOf(polygons, min_grass_probability);
  return Ratio(counts.num_right_grass, counts.num_called);
}

Figure RecallOf(const JudgedPolygons& polygons, double min_grass_probability) {
  const Counts counts = CountsOf(polygons, min_grass_probability);
  return Ratio(counts.num_right_grass, counts.num_grass);
}

Figure AreaUnderCurveOf(const JudgedPolygons& polygons) {
  JudgedPolygons sorted = polygons;
  std::sort(sorted.begin(), sorted.end(), [](const JudgedPolygon& a, const JudgedPolygon& b) {
    return a.probability < b.probability;
  });
  double in_order = 0.0, num_grass = 0.0, num_others_below = 0.0;
  for (size_t first = 0; first < sorted.size();) {
    double grass = 0.0, others = 0.0;
    size_t next = first;
    for (; next < sorted.size() && sorted[next].probability == sorted[first].probability; ++next) {
      (sorted[next].is_grass ? grass : others) += 1.0;
    }
    in_order += grass * (num_others_below + 0.5 * others);
    num_grass += grass;
    num_others_below += others;
    first = next;
  }
  return Ratio(in_order, num_grass * num_others_below);
}

std::array<ReliabilityBin, kNumReliabilityBins> ReliabilityOf(const JudgedPolygons& polygons) {
  std::array<ReliabilityBin, kNumReliabilityBins> bins{};
  for (const JudgedPolygon& polygon : polygons) {
    const auto index = static_cast<size_t>(polygon.probability * kNumReliabilityBins);
    ReliabilityBin& bin = bins.at(std::min(index, kNumReliabilityBins - 1));
    bin.predicted_sum += polygon.probability;
    bin.num_grass += polygon.is_grass ? 1 : 0;
    ++bin.num_polygons;
  }
  return bins;
}

Figure CalibrationErrorOf(const JudgedPolygons& polygons) {
  // A bin's share of the polygons times the difference of its means.
  double sum = 0.0;
  for (const ReliabilityBin& bin : ReliabilityOf(polygons)) {
    sum += std::abs(bin.predicted_sum - bin.num_grass);
  }
  return Ratio(sum, static_cast<double>(polygons.size()));
}

std::optional<Interval> BootstrapInterval(const std::vector<JudgedPolygons>& photographs,
                                          const Statistic& statistic,
                                          uint64_t seed) {
  if (photographs.size() < 2) return std::nullopt;
  std::mt19937_64 generator(seed);
  std::vector<double> figures;
  figures.reserve(kNumDraws);
  for (int draw = 0; draw < kNumDraws; ++draw) {
    JudgedPolygons drawn;
    for (size_t i = 0; i < photographs.size(); ++i) {
      // The standard library's distributions differ between implementations.
      const JudgedPolygons& some = photographs[generator() % photographs.size()];
      drawn.insert(drawn.end(), some.begin(), some.end());
    }
    if (const Figure figure = statistic(drawn)) figures.push_back(*figure);
  }
  if (figures.empty()) return std::nullopt;
  std::sort(figures.begin(), figures.end());
  return Interval{QuantileOf(figures, kLowQuantile), QuantileOf(figures, kHighQuantile)};
}

}  // namespace freelsd
