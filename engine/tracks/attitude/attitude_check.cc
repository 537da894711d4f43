#include "engine/tracks/attitude/attitude_check.h"

#include <cmath>
#include <complex>

#include "engine/tracks/attitude/ground_place.h"

namespace freelsd {
namespace {

using Complex = std::complex<double>;

constexpr int kNumIterations = 10;
// Error from relief, tilt and perspective, in units of the height.
constexpr double kFitSd = 0.05;
constexpr size_t kMinMatches = 8;
// Least ratio of the baseline to the errors of position and tilt.
constexpr double kMinSignificance = 2.5;
// Largest ratio of the two frames' heights above ground.
constexpr double kMaxScale = 2.0;

// a = turn_scale * b + shift, by iterated least squares with Cauchy weights.
struct Similarity {
  Complex turn_scale;
  Complex shift;
};

Similarity FitSimilarity(const std::vector<Complex>& a, const std::vector<Complex>& b) {
  Similarity fit;
  std::vector<double> weights(a.size(), 1.0);
  for (int iteration = 0; iteration < kNumIterations; ++iteration) {
    Complex mean_a, mean_b, across;
    double sum = 0.0, spread = 0.0;
    for (size_t i = 0; i < a.size(); ++i) {
      mean_a += weights[i] * a[i];
      mean_b += weights[i] * b[i];
      sum += weights[i];
    }
    mean_a /= sum;
    mean_b /= sum;
    for (size_t i = 0; i < a.size(); ++i) {
      across += weights[i] * (a[i] - mean_a) * std::conj(b[i] - mean_b);
      spread += weights[i] * std::norm(b[i] - mean_b);
    }
    fit.turn_scale = spread > 0.0 ? across / spread : Complex(0.0);
    fit.shift = mean_a - fit.turn_scale * mean_b;
    for (size_t i = 0; i < a.size(); ++i) {
      const double ratio = std::abs(a[i] - fit.turn_scale * b[i] - fit.shift) / kFitSd;
      weights[i] = 1.0 / (1.0 + ratio * ratio);
    }
  }
  return fit;
}

}  // namespace

std::optional<TurnEvidence> CompareAttitudes(const OrientedFrame& a,
                                             const OrientedFrame& b,
                                             const AlignmentPair& matches) {
  std::vector<Complex> places_a, places_b;
  for (size_t i = 0; i < matches.points_a.size(); ++i) {
    const UnitPlace in_a = UnitPlaceOf(a.world_from_camera, matches.points_a[i]);
    const UnitPlace in_b = UnitPlaceOf(b.world_from_camera, matches.points_b[i]);
    if (!in_a.is_below_horizon || !in_b.is_below_horizon) continue;
    places_a.emplace_back(in_a.place.x(), in_a.place.y());
    places_b.emplace_back(in_b.place.x(), in_b.place.y());
  }
  if (places_a.size() < kMinMatches) return std::nullopt;
  const Similarity fit = FitSimilarity(places_a, places_b);
  const double scale = std::abs(fit.turn_scale);
  if (!(scale > 1.0 / kMaxScale && scale < kMaxScale)) return std::nullopt;
  TurnEvidence evidence;
  evidence.turn_of_b_against_a = std::arg(fit.turn_scale);
  // position_a + height turn_a place_a = position_b + height turn_b place_b.
  const Eigen::Vector2d baseline = (b.position_in_world - a.position_in_world).head<2>();
  const double shift_sd = std::hypot(a.attitude_sd, b.attitude_sd);
  const double baseline_sd = std::hypot(a.position_sd_m, b.position_sd_m);
  if (std::abs(fit.shift) < kMinSignificance * shift_sd) return evidence;
  if (baseline.norm() < kMinSignificance * baseline_sd) return evidence;
  evidence.turn_of_a = std::arg(Complex(baseline.x(), baseline.y()) / fit.shift);
  evidence.turn_of_b = WrapAngle(*evidence.turn_of_a + evidence.turn_of_b_against_a);
  return evidence;
}

std::optional<double> MedianTurn(const std::vector<double>& turns) {
  std::optional<double> best;
  double least = 0.0;
  for (const double candidate : turns) {
    double sum = 0.0;
    for (const double turn : turns) sum += std::abs(WrapAngle(turn - candidate));
    if (best && sum >= least) continue;
    best = candidate;
    least = sum;
  }
  return best;
}

}  // namespace freelsd
