#include "tests/evaluation/places/place_scores.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace freelsd {
namespace {

constexpr size_t kNumBins = 10;

Figure Ratio(double part, double whole) {
  return whole > 0.0 ? Figure(part / whole) : std::nullopt;
}

}  // namespace

Figure ErrorOf(const JudgedPolygons& polygons, double min_grass_probability) {
  const auto num_wrong =
      std::count_if(polygons.begin(), polygons.end(), [&](const JudgedPolygon& polygon) {
        return (polygon.probability >= min_grass_probability) != polygon.is_grass;
      });
  return Ratio(static_cast<double>(num_wrong), static_cast<double>(polygons.size()));
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

Figure CalibrationErrorOf(const JudgedPolygons& polygons) {
  // Predicted less observed of each bin.
  std::array<double, kNumBins> bins{};
  for (const JudgedPolygon& polygon : polygons) {
    const auto index = static_cast<size_t>(polygon.probability * kNumBins);
    bins.at(std::min(index, kNumBins - 1)) += polygon.probability - (polygon.is_grass ? 1.0 : 0.0);
  }
  double sum = 0.0;
  for (const double difference : bins) sum += std::abs(difference);
  return Ratio(sum, static_cast<double>(polygons.size()));
}

}  // namespace freelsd
