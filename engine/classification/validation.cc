#include "engine/classification/validation.h"

#include <algorithm>
#include <limits>
#include <map>
#include <random>
#include <set>
#include <string>
#include <utility>

namespace freelsd {
namespace {

bool HasBothKinds(const SamplePointers& samples) {
  const auto is_grass = [](const TrainingSample* sample) { return sample->is_grass; };
  return std::any_of(samples.begin(), samples.end(), is_grass) &&
         !std::all_of(samples.begin(), samples.end(), is_grass);
}

}  // namespace

SeededRng::SeededRng(int seed) : saved_(cv::theRNG()) {
  cv::theRNG() = cv::RNG(static_cast<uint64_t>(seed));
}

SeededRng::~SeededRng() { cv::theRNG() = saved_; }

std::vector<int> RandomFolds(size_t num_samples, int num_folds, int seed) {
  std::vector<int> folds(num_samples);
  for (size_t i = 0; i < num_samples; ++i) {
    folds[i] = static_cast<int>(i % static_cast<size_t>(num_folds));
  }
  std::mt19937 generator(static_cast<unsigned>(seed));
  // Fisher-Yates by hand: std::shuffle differs between standard libraries.
  for (size_t i = num_samples; i > 1; --i) std::swap(folds[i - 1], folds[generator() % i]);
  return folds;
}

std::vector<int> FoldsByPlace(const std::vector<TrainingSample>& samples) {
  std::map<std::string, int> fold_of_place;
  std::vector<int> folds;
  folds.reserve(samples.size());
  for (const TrainingSample& sample : samples) {
    folds.push_back(
        fold_of_place.emplace(sample.place, static_cast<int>(fold_of_place.size())).first->second);
  }
  return folds;
}

std::vector<Prediction> CrossValidate(const std::vector<TrainingSample>& samples,
                                      const std::vector<int>& fold_of_sample,
                                      const Learner& learner) {
  std::vector<Prediction> predictions;
  const std::set<int> folds(fold_of_sample.begin(), fold_of_sample.end());
  for (const int fold : folds) {
    SamplePointers training;
    for (size_t i = 0; i < samples.size(); ++i) {
      if (fold_of_sample[i] != fold) training.push_back(&samples[i]);
    }
    // Training needs both kinds.
    if (!HasBothKinds(training)) continue;
    const Predictor predict = learner(training);
    for (size_t i = 0; i < samples.size(); ++i) {
      if (fold_of_sample[i] != fold) continue;
      predictions.push_back({predict(samples[i].features), samples[i].is_grass});
    }
  }
  return predictions;
}

double ErrorRatio(const std::vector<Prediction>& predictions) {
  const auto num_wrong =
      std::count_if(predictions.begin(), predictions.end(), [](const Prediction& prediction) {
        return (prediction.votes >= 0.5) != prediction.is_grass;
      });
  return static_cast<double>(num_wrong) / static_cast<double>(predictions.size());
}

double AreaUnderCurve(const std::vector<Prediction>& predictions) {
  double right = 0.0, all = 0.0;
  for (const Prediction& grass : predictions) {
    if (!grass.is_grass) continue;
    for (const Prediction& other : predictions) {
      if (other.is_grass) continue;
      all += 1.0;
      if (grass.votes > other.votes) right += 1.0;
      if (grass.votes == other.votes) right += 0.5;
    }
  }
  return all > 0.0 ? right / all : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace freelsd
