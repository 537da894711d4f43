// Figures of a ground_model on judged polygons: what share is wrong, how well grass is ordered
// before the rest, how well the probabilities are calibrated.
#pragma once

#include <optional>
#include <vector>

namespace freelsd {

struct JudgedPolygon {
  // Probability of grass that the ground_model gave.
  double probability = 0.0;
  bool is_grass = false;
};
using JudgedPolygons = std::vector<JudgedPolygon>;

// A figure is unknown where its denominator is zero.
using Figure = std::optional<double>;

// Share that is called wrongly; a polygon is called grass from min_grass_probability on.
Figure ErrorOf(const JudgedPolygons& polygons, double min_grass_probability);
// Probability that a random polygon of grass has a higher probability than a random other one; a
// tie counts half.
Figure AreaUnderCurveOf(const JudgedPolygons& polygons);

// Mean over the polygons of |mean predicted - observed| of their bin, one of ten. Naeini et al.
// 2015.
Figure CalibrationErrorOf(const JudgedPolygons& polygons);

}  // namespace freelsd
