// Input: a recorded flight that photographs the same ground on several legs. Output: what the watch
// says of photographs of one leg against the picture that the other legs give. Nothing was changed
// between them on purpose: what it tells is false, or moved in those minutes. Strips lie on land
// that people outlined (tests/evaluation/fields/outlines).
#pragma once

#include <string>
#include <vector>

#include "engine/classification/classification.h"
#include "engine/watch/watch.h"
#include "tests/evaluation/watch/watch_log.h"

namespace freelsd {

struct RecordedWatchOptions {
  WatchOptions watch;
  // Parts of the flight, one after the other; each is compared with the rest.
  int num_parts = 4;
  // Strips lie this far apart.
  double spacing_m = 15.0;
  // Pictures of all that was told, PNG; "" for none.
  std::string pictures;
};

std::vector<WatchRow> WatchRecorded(const std::string& folder,
                                    const RecordedWatchOptions& options,
                                    const Classifier& classifier);

}  // namespace freelsd
