// Judges a ground_model on the photographs of all places, several at once. It only judges and never
// trains.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace freelsd {

struct PlaceRunOptions {
  // Folder with one folder of photographs per place.
  std::string photographs;
  // Folder with PLACE.txt for every place and perhaps second_opinion.txt; see place_labels.h.
  std::string labels;
  // File, see place_cameras.h.
  std::string cameras;
  // File of the network; "": each place has that of its fold.
  std::string model;
  // Places to judge. Empty: all that have labels.
  std::vector<std::string> places;
  // Photographs at once. It does not change the report.
  int num_jobs = 1;
  // Swaps grass and not grass in every answer, to show that the report notices it.
  bool swaps_kinds = false;
};

// See MakePlaceReport. Throws std::runtime_error if a file cannot be read.
nlohmann::json RunPlaces(const PlaceRunOptions& options);

}  // namespace freelsd
