// Scores of a classifier and of the segmentation on labelled photographs.
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

// Returns num_regions, error, auc, precision, recall, num_unsure, false_grass (share of the regions
// without grass that are classified as grass), and by_class (for each class, the number of regions,
// and the number classified as grass). Unsure counts as not grass. Unlabelled regions are left out;
// dormant grass counts only in by_class.
nlohmann::ordered_json Scores(const std::vector<Answer>& answers);

// Scores of all regions, and scores by place.
nlohmann::ordered_json ScoresByPlace(const std::vector<Answer>& answers);

// All regions that are classified as grass but labelled as another class, without dormant grass.
nlohmann::ordered_json FalseGrass(const std::vector<Answer>& answers);

// Cross-validation by place. For each place, settings, forest, calibration and range are trained on
// the samples of all other places; the resulting classifier answers for the photographs of this
// place.
std::vector<Answer> AnswersOfUnseenPlaces(const Photographs& photographs,
                                          const std::vector<TrainingSample>& samples,
                                          const TrainingOptions& options);

// Returns three numbers over all photographs, and by place. covered: share of labelled grass that
// lies in a region, mean over the photographs with grass. purity: share of the labelled pixels in
// regions that have the same class as most pixels of their region, with two classes: grass and not
// grass. grass_purity: the same share in regions that are mostly grass.
nlohmann::ordered_json SegmentationScores(const Photographs& photographs,
                                          const SegmentationOptions& options);

}  // namespace freelsd
