// Judges a classifier on the photographs of all places: several at once, to be interrupted and
// continued, in parts that are merged. It only judges and never trains.
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
  // File of the classifier.
  std::string model;
  // Places to judge. Empty: all that have labels.
  std::vector<std::string> places;
  // Names, see place_variation.h.
  std::vector<std::string> variations{"none"};
  // Photographs at once. It does not change the report.
  int num_jobs = 1;
  // Report to write after every photograph. Empty: none.
  std::string json;
  // Continues from that report: its photographs are not judged again.
  bool resumes = false;
  // Folder for pictures of the photographs, polygons and answers. Empty: none.
  std::string pictures;
  // Swaps grass and not grass in every answer, to show that the report notices it.
  bool swaps_kinds = false;

  // Throws std::invalid_argument.
  void Check() const;
};

// See MakePlaceReport. Throws std::runtime_error if a file cannot be read, or if the report to
// continue from has other settings.
nlohmann::json RunPlaces(const PlaceRunOptions& options);

// One report on the photographs of several. Throws std::runtime_error if settings differ or if two
// of them hold the same photograph in the same variation.
nlohmann::json MergePlaceReports(const std::vector<nlohmann::json>& reports);

}  // namespace freelsd
