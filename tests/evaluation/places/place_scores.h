// Figures of a classifier on judged polygons: what share is wrong, how well grass is ordered before
// the rest, how well the probabilities are calibrated.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

namespace freelsd {

struct JudgedPolygon {
  // Probability of grass that the classifier gave.
  double probability = 0.0;
  bool is_grass = false;
};
using JudgedPolygons = std::vector<JudgedPolygon>;

// A figure is unknown where its denominator is zero.
using Figure = std::optional<double>;

// Share that is called wrongly; a polygon is called grass from min_grass_probability on.
Figure ErrorOf(const JudgedPolygons& polygons, double min_grass_probability);
// Share of grass among what is called grass.
Figure PrecisionOf(const JudgedPolygons& polygons, double min_grass_probability);
// Share of the grass that is called grass.
Figure RecallOf(const JudgedPolygons& polygons, double min_grass_probability);
// Probability that a random polygon of grass has a higher probability than a random other one; a
// tie counts half.
Figure AreaUnderCurveOf(const JudgedPolygons& polygons);

struct ReliabilityBin {
  double predicted_sum = 0.0;
  int num_grass = 0;
  int num_polygons = 0;
};
constexpr size_t kNumReliabilityBins = 10;
// Bin i holds the probabilities in [i / 10, (i + 1) / 10), the last bin also 1.
std::array<ReliabilityBin, kNumReliabilityBins> ReliabilityOf(const JudgedPolygons& polygons);
// Mean over the polygons of |mean predicted - observed| of their bin. Naeini et al. 2015.
Figure CalibrationErrorOf(const JudgedPolygons& polygons);

struct Interval {
  double low = 0.0;
  double high = 0.0;
};
using Statistic = std::function<Figure(const JudgedPolygons&)>;
// 95 % interval by bootstrap. It draws whole photographs, because polygons of one photograph are
// alike. Draws without a figure are left out. The same input and seed give the same interval.
// Unknown for fewer than two photographs.
std::optional<Interval> BootstrapInterval(const std::vector<JudgedPolygons>& photographs,
                                          const Statistic& statistic,
                                          uint64_t seed);

}  // namespace freelsd
