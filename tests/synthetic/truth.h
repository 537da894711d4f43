// Input: a world and an aircraft. Output: what is truly landable, computed from the world itself
// and not with the code that is judged by it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <opencv2/core.hpp>

#include "engine/flight/flight.h"
#include "tests/synthetic/world.h"

namespace freelsd {

// Why a place or a field is not landable; empty strings mean it is.
struct TrueField {
  Parcel parcel;
  bool is_landable = false;
  // Where the nearest non-landable ground is farthest away among touchdowns whose final is clear.
  std::optional<Eigen::Vector2d> touchdown;
  // Distance from there to the nearest ground that is not landable.
  double free_radius = 0.0;
  std::string reason;
};

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

// Landable ground on a grid of `cell_size_m` over the world, row 0 south: 255 where meadow, even
// and smooth enough for the aircraft and nothing stands on it, else 0.
cv::Mat1b LandableGround(const World& world, const Aircraft& aircraft, double cell_size_m = 1.0);

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

// One judgement per meadow of the world. A true field has a touchdown whose disc, ground roll and
// final are free for the world's wind; the loiter circle is scored apart.
std::vector<TrueField> JudgeFields(const World& world, const Aircraft& aircraft);

}  // namespace freelsd
