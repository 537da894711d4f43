// How far the errors at surveyed targets depend on luck: the same flight again and again, each time
// without another photograph and with the adjustment stopped at another tolerance.
#pragma once

#include <string>
#include <vector>

#include "tests/evaluation/recorded/control_points.h"

namespace freelsd {

struct ControlTrial {
  // Of the adjustment: from 1e-4, the engine's own, to 1e-8, in equal factors.
  double function_tolerance = 1e-4;
  // The photograph that is left out, spread evenly over the flight.
  size_t left_out = 0;
};

// Throws std::invalid_argument unless 1 <= num_runs <= num_photographs.
std::vector<ControlTrial> PlanControlRuns(size_t num_runs, size_t num_photographs);

struct ControlRun {
  ControlTrial trial;
  std::string left_out_id;
  size_t num_in_block = 0;
  ControlErrors errors;
  // From the first photograph to the map.
  double seconds = 0.0;
};

// Photographs and what is known about the ground.
struct ControlFlight {
  RecordedFrames recorded;
  Targets targets;
  std::vector<TargetSighting> sightings;
};

ControlRun RunControl(const ControlFlight& flight,
                      const ControlTrial& trial,
                      const GroundModel& ground_model,
                      PipelineOptions options);

// Parts of a table in Markdown, each of whole lines: the heading, a row for each run, and the end
// with their medians, their largest, and the heights of all runs beyond three stated deviations.
std::string ControlHeading();
std::string ControlRow(const ControlRun& run);
std::string ControlEnd(const std::vector<ControlRun>& runs);

}  // namespace freelsd
