// Input: a world and an aircraft. Output: what is truly landable, computed from the world itself
// and not with the code that is judged by it.
#pragma once

#include "engine/flight/flight.h"
#include "tests/synthetic/world.h"

namespace freelsd {

// What is wrong with a cell of ground, first rule that fails.
enum class GroundFault : uint8_t {
  kNone,
  kOutside,  // border of the world: beyond it nothing is known
  kCover,    // something else than meadow, or something stands on it
  kSteep,
  kRough,
};
// Of the square cell of `cell_size_m` around a place.
GroundFault GroundFaultAt(
    const World& world, const Aircraft& aircraft, double x, double y, double cell_size_m);

// Length over ground of the final into the world's wind; zero or negative where it is too strong.
double TrueFinalLength(const World& world, const Aircraft& aircraft);

// Smallest height of the final over what stands in its corridor, from the touchdown uncertainty
// outward, less the clearance the aircraft wants there; negative is blocked. Into the world's wind.
double FinalReserve(const World& world, const Aircraft& aircraft, const Eigen::Vector2d& touchdown);
// The same for one loiter circle at the start of the final: `side` +1 is left of the heading.
double LoiterReserve(const World& world,
                     const Aircraft& aircraft,
                     const Eigen::Vector2d& touchdown,
                     int side);

}  // namespace freelsd
