// Compares the photographs of a batch with each other: a wrong fix, another camera or angles of
// another convention show only beside the others.
#pragma once

#include <string>
#include <vector>

#include "api/api.h"
#include "server/intake/batch.h"

namespace freelsd {

// A photograph with its metadata from the pose file, from its tags, and merged.
struct BatchPhoto {
  BatchImage image;
  FrameMeta given;
  FrameMeta tags;
  FrameMeta meta;
};

enum class BatchAngles {
  kChecked,  // angles that make every camera look at the horizon are not used
  kGiven,    // all angles are used as they are
  kNone,     // no angles are used; the attitudes come from matches
};

struct PhotoRules {
  BatchAngles angles = BatchAngles::kChecked;
  // The flight's camera and mounting are given; else the photographs determine them.
  bool has_camera = false;
  bool has_mounting = false;
};

struct ComparedPhotos {
  std::vector<BatchPhoto> photos;
  std::vector<std::string> warnings;
};
// `photos` in the order of flight. Returns them in the same order. A photograph that cannot be of
// this flight gets the code OddPhotograph and the reason.
ComparedPhotos ComparePhotos(std::vector<BatchPhoto> photos, const PhotoRules& rules);

}  // namespace freelsd
