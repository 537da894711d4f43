// Input: a seed and a kind of world. Output: a few frames of a flight over it, and what their
// pixels truly show.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "server/training/pools.h"
#include "tests/evaluation/frames/labelled_picture.h"
#include "tests/evaluation/synthetic_flight.h"

namespace freelsd {

// A kind of world.
struct WorldLook {
  std::string name;
  ScenarioOptions scenario;
};

// "painted", "textured" (recorded texture and conditions, at cells of 0.1 m) and "ground" (real
// ground of the pool, with both).
std::vector<WorldLook> WorldLooks(Pool pool, int num_frames);

// At full size. Photographs lie so far apart that they show different ground. The seed and the
// ground are added to `run`.
std::vector<LabelledPicture> RenderPictures(uint64_t seed, const WorldLook& look, PoolOfRun& run);

}  // namespace freelsd
