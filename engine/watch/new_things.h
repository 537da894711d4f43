// From changed pixels to things.
#pragma once

#include <vector>

#include "engine/watch/change.h"

namespace freelsd {

struct NewThings {
  std::vector<NewThing> things;
  // Pixels of changes that are too large to be things.
  int num_changed_ground = 0;
};
NewThings ThingsIn(const StripChange& change,
                   const StripCanvas& canvas,
                   const StripGround& ground,
                   const WatchOptions& options);

}  // namespace freelsd
