// Flies over a seeded world, stores its sites, and watches them in later passes.
#pragma once

#include <string>
#include <vector>

#include "engine/classification/classification.h"
#include "engine/watch/watch.h"
#include "tests/evaluation/synthetic_flight.h"
#include "tests/evaluation/watch/watch_log.h"

namespace freelsd {

struct WatchRunOptions {
  ScenarioOptions scenario;
  WatchOptions watch;
  int num_passes = 20;
  int max_num_strips = 3;
  bool has_events = false;
  // Heights of the later passes as shares of that of the stored one, in turns.
  std::vector<double> height_ratios{0.7, 1.0, 1.3};
  // Rows are added to this file pass by pass; "" for none.
  std::string log;
  // Pictures of misses and false alarms, PNG; "" for none.
  std::string pictures;
};

std::vector<WatchRow> WatchWorld(uint64_t seed,
                                 const WatchRunOptions& options,
                                 const Classifier& classifier);

}  // namespace freelsd
