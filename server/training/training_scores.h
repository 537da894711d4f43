// Scores of a model and of the segmentation on labelled photographs.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "server/training/training_data.h"

namespace freelsd {

// The classifier's answer for one labelled region.
struct Answer {
  // Photograph and region, for a person who checks the answer.
  std::string where;
  std::string place;
  Label label;
  int surface_class = kUnlabelledClass;
};
std::vector<Answer> AnswersOf(const Photographs& photographs, const Classifier& classifier);

// Returns num_regions, error, auc, precision, recall, num_unsure, false_grass (share of regions
// without grass that are classified as grass), and this share by class. Unsure counts as not grass.
nlohmann::ordered_json Scores(const std::vector<Answer>& answers);

// Scores of all, and by place.
nlohmann::ordered_json ScoresByPlace(const std::vector<Answer>& answers);

// Every region that is classified as grass and is not grass.
nlohmann::ordered_json FalseGrass(const std::vector<Answer>& answers);

// Cross-validation by place. For each place: trains settings, forest, calibration and range on the
// samples of all other places, then answers on the photographs of this place.
std::vector<Answer> AnswersOfUnseenPlaces(const Photographs& photographs,
                                          const std::vector<TrainingSample>& samples,
                                          const TrainingOptions& options);

// Returns scores of all photographs, and by place. covered: share of labelled grass that lies in a
// region, mean over the photographs with grass. purity: share of a region's labelled pixels that
// agree with its majority, grass or not. grass_purity: purity of regions that are mostly grass.
nlohmann::ordered_json SegmentationScores(const Photographs& photographs,
                                          const SegmentationOptions& options);

}  // namespace freelsd
