// Input: a recorded flight, outlines drawn on its photographs, an aircraft. Output: what
// the engine accepted in many winds, judged, and what became of each field.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "tests/evaluation/engine_run.h"
#include "tests/evaluation/fields/distinct_sites.h"
#include "tests/evaluation/fields/labelled_fields.h"
#include "tests/evaluation/recorded/recorded_flight.h"
#include "tests/evaluation/scores/blinding.h"

namespace freelsd {

struct FieldResult {
  LabelledField field;
  // Of all winds, those in which the aircraft fits on the field, and of these those with an
  // accepted touchdown in it.
  std::vector<std::string> winds_that_fit;
  std::vector<std::string> winds_found;
  // "found"; else the first rule that the middle of the field breaks in calm air, with
  // "hazard_distance" the rule that most cells within this distance break; if it breaks none, what
  // the frontend made of it: "no region", "region without a grade", "touchdown elsewhere".
  std::string fate;
  // The rule's own words.
  std::string detail;
};

// Counts of distinct sites.
struct SiteCounts {
  int num_accepted = 0;
  int num_right = 0;
  int num_false_safe = 0;
  int num_thin = 0;
  int num_not_judged = 0;
  // Of those not judged: some of the ground has an outline of doubt.
  int num_in_doubt = 0;
};
SiteCounts CountsOf(const std::vector<DistinctSite>& sites);

struct FieldSurvey {
  std::string flight;
  Aircraft aircraft;
  EngineRun run;
  // Those that the run's poses cannot place are only counted.
  LabelledGround ground;
  int num_outlines = 0;
  int num_outlines_without_view = 0;
  std::vector<DistinctSite> sites;
  std::vector<FieldResult> fields;
  // Sites where all labelled ground is given as regions: "none", then by the name of the blinding.
  std::map<std::string, std::vector<DistinctSite>> sites_on_labels;
};

struct FieldSurveyInput {
  // Name of the flight.
  std::string flight;
  const RecordedFrames& frames;
  const std::vector<Outline>& outlines;
  Aircraft aircraft;
  std::vector<Blinding> blindings;
  PipelineOptions options = {};
};

// The outlines on the ground of a run's map.
LabelledGround LabelledGroundOf(const std::vector<Outline>& outlines, const Evaluation& evaluation);

// Throws std::runtime_error when the plans for an unknown wind are not those of the engine.
FieldSurvey SurveyFields(const FieldSurveyInput& input, const GroundModel& ground_model);

}  // namespace freelsd
