// Private to glide/: ways to the start of a final that are longer than the shortest one, so that
// they lose a given height.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "engine/glide/transit.h"

namespace freelsd {

// A turn, then a straight piece; either may be 0. Turns are in radians, positive to the right.
struct Leg {
  double turn = 0.0;
  double straight_m = 0.0;
};

// Legs in order of flight, in the frame of the moving air. All turns have the performance's radius.
struct Way {
  std::vector<Leg> legs;
  // Legs until which the rest of a longer way can be left out: the shortest way from there loses
  // less height.
  size_t num_legs_to_decision = 0;
  Performance performance;
  double time = 0.0;
  double height_lost = 0.0;
};

// Height that may be left: a way loses at most this much less than asked for.
inline constexpr double kWayHeightTolerance = 0.5;

// The shortest way, as it is.
Way WayOf(const Transit& transit);

// The first way that loses `height_lost` and is taken by `takes`, of one of each kind. First those
// that are longer near their end, because they can be cut short for long:
// - a longer straight piece before the final;
// - wider turns;
// - a bend to one side of the straight piece, or to the other;
// - straight on before the first turn;
// - a whole turn, as wide as needed, before the first turn;
// - turned away first, then straight on.
// `shortest` is the shortest transit of this task.
std::optional<Way> WayLosing(const TransitTask& task,
                             const Transit& shortest,
                             double height_lost,
                             const std::function<bool(const Way&)>& takes);

}  // namespace freelsd
