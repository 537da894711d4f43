// Many surveys of fields: several flights at once, to be interrupted and gone on with.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "tests/evaluation/scores/blinding.h"

namespace freelsd {

struct FieldCampaignOptions {
  // Folders with images/ and perhaps poses.csv.
  std::vector<std::string> flights;
  std::vector<std::string> aircraft{"small", "techpod"};
  // Folder with FLIGHT.txt for each flight.
  std::string labels = FREELSD_SOURCE_DIR "/tests/evaluation/fields/outlines";
  std::vector<Blinding> blindings;
  // As in CampaignOptions.
  nlohmann::json engine_options = nlohmann::json::object();
  // "": as ModelFileOf says.
  std::string model;
  // Flights at once; no result depends on it.
  int num_jobs = 1;
  // Report to write after every survey; "" for none.
  std::string json;
  // Go on from that report: its flights and aircraft are not run again.
  bool resumes = false;

  // Throws std::invalid_argument.
  void Check() const;
  // The model given, else the one that learned nothing from the flight's place, else the options'
  // own.
  std::string ModelFileOf(const std::string& flight) const;
};

// {"settings": ..., "surveys": [...]}, by flight and aircraft. Throws std::runtime_error when
// nothing can be read, or when the report to go on from has other settings.
nlohmann::json RunFieldCampaign(const FieldCampaignOptions& options);

}  // namespace freelsd
