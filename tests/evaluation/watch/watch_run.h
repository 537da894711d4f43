// Flies over a seeded world, stores its sites, photographs them in later passes, and watches them.
#pragma once

#include <string>
#include <vector>

#include "engine/classification/classification.h"
#include "engine/watch/watch.h"
#include "tests/evaluation/synthetic_flight.h"
#include "tests/evaluation/watch/watch_log.h"

namespace freelsd {

struct PhotographOptions {
  ScenarioOptions scenario;
  // Later passes over each world with something new on the strip, and without.
  int num_events = 20;
  int num_quiet = 20;
  int max_num_strips = 3;
  // Heights of the later passes as shares of that of the stored one.
  std::vector<double> height_ratios{0.7, 1.0, 1.3};
  std::string folder;
};

// Stores the world's strips and photographs the later passes, as files in the folder: the first
// quiet pass after so many passes with events. Files that are there are not made again. A world
// without a strip leaves no files.
void PhotographWorld(uint64_t seed, const PhotographOptions& options, const Classifier& classifier);

struct WatchRunOptions {
  WatchOptions watch;
  // Rows are added to this file pass by pass; "" for none.
  std::string log;
  // Pictures of misses and false alarms, PNG; "" for none.
  std::string pictures;
};

// The passes in a folder, in the order of their names.
std::vector<WatchRow> WatchPasses(const std::string& folder, const WatchRunOptions& options);

}  // namespace freelsd
