// Many worlds: several at once, to be interrupted and gone on with.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "engine/ground_kind/ground_kind.h"
#include "tests/evaluation/runs/runs.h"
#include "tests/evaluation/synthetic_flight.h"

namespace freelsd {

struct CampaignOptions {
  int num_worlds = 6;
  // Of the first world; the others follow.
  uint64_t seed = 1000;
  // Worlds at once. Each needs the memory of a world, and its engine has one thread.
  int num_jobs = 1;
  ScenarioOptions scenario;
  // Options of the engine, {preset: name, stage: {field: value}} with any field of any stage; the
  // others are the defaults, or those of the preset.
  nlohmann::json engine_options = nlohmann::json::object();
  // Report to write after every world; "" for none.
  std::string json;
  // Go on from that report: its seeds are not flown again.
  bool resumes = false;
  // Ends with the map: its heights and poses are scored, nothing is planned.
  bool is_heights_only = false;
  // What of the truth the engine is given (NamesOfGiven).
  std::vector<std::string> given;
  // Of Blinding: the map is made wrong on purpose before it is planned on; "" for none. "each": the
  // run is scored as it is, and all of them are counted besides.
  std::string blind;
  // Steps of the engine that are left out in turn, besides (ablation/ablation.h).
  nlohmann::json ablations = nlohmann::json::object();

  // Throws std::invalid_argument.
  void Check() const;
  // The file of the ground_model that belongs to the options.
  std::string ModelFile() const;
};

// The report of all worlds, by seed. Whatever the number of jobs, the records are the same but for
// what they cost.
nlohmann::json RunCampaign(const CampaignOptions& options, const GroundModel& ground_model);

}  // namespace freelsd
