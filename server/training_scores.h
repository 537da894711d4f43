// How well a model tells labelled regions apart, and how well the segmentation cuts them out.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "server/training_data.h"

namespace freelsd {

// What the service would say of one labelled region.
struct Answer {
  // Photograph and region, for a human to look at.
  std::string where;
  std::string place;
  Label label;
  int surface_class = kUnlabelledClass;
};
std::vector<Answer> AnswersOf(const Photographs& photographs, const Classifier& classifier);

// num_regions, error, auc, precision, recall, num_unsure, false_grass (share of what is not grass
// that is called grass) and the same by class. Unsure counts as not grass.
nlohmann::ordered_json Scores(const std::vector<Answer>& answers);

// Scores of all, and by place.
nlohmann::ordered_json ScoresByPlace(const std::vector<Answer>& answers);

// Every region that is not grass and was called so.
nlohmann::ordered_json FalseGrass(const std::vector<Answer>& answers);

// Everything anew for each place: settings, forest, calibration and range from the samples of the
// other places; answers on the photographs of that place.
std::vector<Answer> AnswersOfUnseenPlaces(const Photographs& photographs,
                                          const std::vector<TrainingSample>& samples,
                                          const TrainingOptions& options);

// covered: share of labelled grass in a region, mean over the photographs that have any; purity:
// share of a region's labelled pixels that agree with its majority, grass or not; grass_purity: the
// same of regions that are mostly grass. All together, and by place.
nlohmann::ordered_json SegmentationScores(const Photographs& photographs,
                                          const SegmentationOptions& options);

}  // namespace freelsd
