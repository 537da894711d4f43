// A network's answers for the labelled polygons of one photograph.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "engine/ground_kind/ground_kind.h"
#include "tests/evaluation/places/place_labels.h"

namespace freelsd {

// A photograph to judge, and its labels.
struct PlacePhotograph {
  std::string place;
  std::string name;
  cv::Mat3b image;
  // Metres on the ground per pixel of `image`.
  double ground_sampling_m = 0.0;
  std::vector<PlacePolygon> polygons;
};

struct PolygonAnswer {
  std::string id;
  PlaceClass surface = PlaceClass::kGrass;
  std::optional<PlaceClass> second_opinion;
  double area_m2 = 0.0;
  // Share of the polygon where the network does not tell the kind.
  double not_told_ratio = 0.0;
  // Mean probability of grass where the kind is told. Unknown if that is less than half.
  std::optional<double> probability;
};

struct PhotographAnswers {
  std::string place;
  std::string photograph;
  double ground_sampling_m = 0.0;
  std::vector<PolygonAnswer> polygons;
};

// The answers for the polygons, in the order of the labels. Throws std::runtime_error that names
// the polygon if a polygon lies outside the photograph.
std::vector<PolygonAnswer> AnswersOf(const PlacePhotograph& photograph, const KindModel& model);

// Swaps grass and not grass in every answer. A report of swapped answers must look bad.
void SwapKinds(PhotographAnswers& answers);

nlohmann::json ToJson(const PhotographAnswers& answers);

}  // namespace freelsd
