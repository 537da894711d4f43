// Input: a map and the world it is about. Output: which of the things that stand on the ground the
// map shows, by their kind, width and height.
#pragma once

#include <array>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "tests/evaluation/engine_run.h"
#include "tests/evaluation/scores/map_shift.h"
#include "tests/evaluation/synthetic_flight.h"

namespace freelsd {

// What a map says of a thing.
enum class ThingFate {
  kFound,    // its height, within 1 m, and within half of its own height
  kUnknown,  // height too low, but most of its ground is unseen or has an unsure height
  kHazard,   // height too low, but most of its ground is a hazard or unknown
  kMissed,   // low and free
};
constexpr size_t kNumThingFates = 4;

// A connected piece of one kind of cover that stands higher than 0.3 m at some place.
struct Thing {
  Cover kind = Cover::kTree;
  // Of the widest circle in it: a hedge is as wide as it is across. Metres.
  double width = 0.0;
  // Largest, over the ground below; metres.
  double height = 0.0;
  // Centres of its cells.
  std::vector<Eigen::Vector2d> places;

  // "hedge/1-3/0.5-1.5": kind, width in metres, height in metres.
  std::string ClassName() const;
};

// Trees with and without leaves, hedges, houses, boulders, vehicles, animals, fences and poles, as
// far as they lie within the grid. In a fixed order.
std::vector<Thing> ThingsWithin(const World& world, const Grid& grid);

// The offset of the map is taken off first.
ThingFate FateOfThing(const Thing& thing,
                      const World& world,
                      const ElevationMap& map,
                      const HazardLayers& layers,
                      const MapOffset& offset);

// Of the things on ground that the flight saw: what was not photographed, no map can show. By
// class; the counts are in the order of ThingFate.
using ThingCounts = std::map<std::string, std::array<int64_t, kNumThingFates>>;
struct ThingScores {
  ThingCounts counts;
  // Class and middle of each missed thing, to be looked at.
  std::vector<std::pair<std::string, Eigen::Vector2d>> missed;
};
ThingScores ScoreThings(const Scenario& scenario,
                        const ElevationMap& map,
                        const HazardLayers& layers,
                        const MapOffset& offset);

}  // namespace freelsd
