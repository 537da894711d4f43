#include "engine/glide/shortest_turns.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "engine/geometry/geometry.h"

namespace freelsd {
namespace {

constexpr double kNoStraight = 1e-6;  // radii

// In [0, 2 pi). Rounding just below a whole turn becomes 0.
double Turn(double angle) {
  constexpr double kNoTurn = 1e-6;
  double turn = std::fmod(angle, 2.0 * kPi);
  if (turn < 0.0) turn += 2.0 * kPi;
  return turn > 2.0 * kPi - kNoTurn ? 0.0 : turn;
}

// Distance d in radii and both headings counter-clockwise from the line between the places, as in
// Shkel and Lumelsky, "Classification of the Dubins set", 2001, Eq. 6 to 17. All words share the
// sines and cosines of the headings.
struct Problem {
  Problem(double distance, double from, double to) : d(distance), alpha(from), beta(to) {}
  double d, alpha, beta;
  double sin_alpha = std::sin(alpha), cos_alpha = std::cos(alpha);
  double sin_beta = std::sin(beta), cos_beta = std::cos(beta);
};

// Lengths in radii; angles are not negative. `sense` of the first turn: 1 is left, -1 is right.
struct Word {
  double sense, first, straight, middle, last;
  // Relative to the sense of the first turn.
  double last_sense;
  double Length() const { return first + straight + middle + last; }
};

// Both turns in the same sense.
Word SameSense(const Problem& p, double sense) {
  const double x = p.d - sense * (p.sin_beta - p.sin_alpha);
  const double y = -sense * (p.cos_alpha - p.cos_beta);
  const double straight = std::hypot(x, y);
  // Both turns share one circle: a straight piece of zero length has no direction.
  if (straight < kNoStraight) {
    return {sense, Turn(sense * (p.beta - p.alpha)), straight, 0.0, 0.0, 1.0};
  }
  const double direction = std::atan2(y, x);
  const double first = Turn(sense * (direction - p.alpha));
  return {sense, first, straight, 0.0, Turn(sense * (p.beta - direction)), 1.0};
}

// A turn in this sense, then one in the other. Nothing if the circles overlap.
std::optional<Word> OtherSense(const Problem& p, double sense) {
  // Centres one radius to the side of each place.
  const double x = p.d + sense * (p.sin_beta + p.sin_alpha);
  const double y = -sense * (p.cos_beta + p.cos_alpha);
  const double between = std::hypot(x, y);
  // Circles that touch may overlap by a rounding error.
  if (between < 2.0 - kNoStraight) return std::nullopt;
  const double direction = std::atan2(y, x) + sense * std::asin(std::min(1.0, 2.0 / between));
  const double first = Turn(sense * (direction - p.alpha));
  const double straight = std::sqrt(std::max(0.0, between * between - 4.0));
  return Word{sense, first, straight, 0.0, Turn(sense * (direction - p.beta)), -1.0};
}

// Three arcs; the middle one has the opposite sense and is longer than half a turn.
std::optional<Word> ThreeArcs(const Problem& p, double sense) {
  const double x = p.d - sense * (p.sin_beta - p.sin_alpha);
  const double y = -sense * (p.cos_alpha - p.cos_beta);
  const double between = std::hypot(x, y);
  if (between > 4.0) return std::nullopt;
  const double middle = 2.0 * kPi - 2.0 * std::asin(between / 4.0);
  // The outer arcs make up the rest of the change of heading.
  const double first = Turn(sense * (std::atan2(y, x) - p.alpha) + middle / 2.0);
  const double last = Turn(sense * (p.beta - p.alpha) + middle - first);
  return Word{sense, first, 0.0, middle, last, 1.0};
}

}  // namespace

TurnPath ShortestTurns(const Stance& from, const Stance& to, double radius_m) {
  const Eigen::Vector2d way = to.place - from.place;
  const double direction = way.norm() > 0.0 ? std::atan2(way.y(), way.x()) : 0.0;
  const Problem problem(way.norm() / radius_m,
                        kPi / 2.0 - from.heading - direction,
                        kPi / 2.0 - to.heading - direction);
  Word best = SameSense(problem, 1.0);
  const auto improve = [&best](const std::optional<Word>& word) {
    if (word && word->Length() < best.Length()) best = *word;
  };
  improve(OtherSense(problem, 1.0));
  improve(ThreeArcs(problem, 1.0));
  improve(SameSense(problem, -1.0));
  improve(OtherSense(problem, -1.0));
  improve(ThreeArcs(problem, -1.0));
  const double to_the_right = -best.sense;
  return {to_the_right * best.first,
          best.straight * radius_m,
          -to_the_right * best.middle,
          to_the_right * best.last_sense * best.last};
}

double TurnPath::Turned() const {
  return std::abs(first_turn) + std::abs(middle_turn) + std::abs(last_turn);
}

}  // namespace freelsd
