// Input: worlds whose truth is known, and recorded flights with labels. Output: what every map cell
// of the engine's map is, and its cues.
#pragma once

#include <string>

#include "engine/pipeline.h"
#include "tests/evaluation/kinds/kind_cells.h"
#include "tests/evaluation/synthetic_flight.h"

namespace freelsd {

struct KindSourceOptions {
  // Of the engine; rules of the cover have no influence.
  PipelineOptions engine;
  // Folder for pictures of orthophotos with their kinds; "" for none.
  std::string pictures;
};

KindRasters KindsOfWorld(uint64_t seed,
                         const ScenarioOptions& scenario,
                         const Classifier& classifier,
                         const KindSourceOptions& options);

// `folder`: of the flight, whose name has outlines in fields/outlines/ and labels in labels/.
KindRasters KindsOfFlight(const std::string& folder,
                          const Classifier& classifier,
                          const KindSourceOptions& options);

}  // namespace freelsd
