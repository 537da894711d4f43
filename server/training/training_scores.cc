#include "server/training/training_scores.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <map>
#include <set>

namespace freelsd {
namespace {

using Json = nlohmann::ordered_json;

// In an evaluation, one labelled pixel is enough for a region to have a class.
constexpr double kAnyLabel = 0.0;
constexpr std::array<const char*, kNumClasses> kClassNames{"unlabelled",
                                                           "grass",
                                                           "tree",
                                                           "tall_growth",
                                                           "crop",
                                                           "soil",
                                                           "paved",
                                                           "building",
                                                           "water",
                                                           "dormant_grass"};

Json Ratio(double part, double whole) {
  if (whole > 0.0) return part / whole;
  return nullptr;
}

bool IsGrass(const Answer& answer) { return answer.surface_class == kGrassClass; }

bool IsCalledGrass(const Answer& answer) { return answer.label.surface == Surface::kGrass; }

bool IsLabelled(const Answer& answer) {
  return answer.surface_class != kUnlabelledClass && answer.surface_class != kDormantGrassClass;
}

Json AreaUnderCurve(const std::vector<Answer>& answers) {
  double in_order = 0.0, pairs = 0.0;
  for (const Answer& grass : answers) {
    for (const Answer& other : answers) {
      if (!IsGrass(grass) || IsGrass(other)) continue;
      pairs += 1.0;
      in_order += grass.label.probability > other.label.probability ? 1.0 : 0.0;
      in_order += grass.label.probability == other.label.probability ? 0.5 : 0.0;
    }
  }
  return Ratio(in_order, pairs);
}

template <class Predicate>
std::vector<Answer> Where(const std::vector<Answer>& answers, Predicate&& predicate) {
  std::vector<Answer> some;
  std::copy_if(answers.begin(), answers.end(), std::back_inserter(some), predicate);
  return some;
}

// Share of the regions of each class that are classified as grass.
Json CalledGrassByClass(const std::vector<Answer>& answers) {
  Json by_class;
  for (int surface_class = kGrassClass; surface_class < kNumClasses; ++surface_class) {
    const std::vector<Answer> some =
        Where(answers, [&](const Answer& answer) { return answer.surface_class == surface_class; });
    if (some.empty()) continue;
    by_class[kClassNames[static_cast<size_t>(surface_class)]] = {
        {"num_regions", some.size()},
        {"num_called_grass", std::count_if(some.begin(), some.end(), IsCalledGrass)}};
  }
  return by_class;
}

// Sums over regions, in labelled pixels.
struct Tally {
  double agreeing = 0.0;
  double labelled = 0.0;
  double grass_region_agreeing = 0.0;
  double grass_region_labelled = 0.0;
  double covered_sum = 0.0;
  int num_photographs_with_grass = 0;
};

void AddRegion(double grass, double other, Tally& tally) {
  tally.agreeing += std::max(grass, other);
  tally.labelled += grass + other;
  if (grass <= other) return;
  tally.grass_region_agreeing += grass;
  tally.grass_region_labelled += grass + other;
}

void AddPhotograph(const LabelledRegions& regions, Tally& tally) {
  std::vector<double> grass(regions.classes.size() + 1, 0.0), other(grass);
  for (int y = 0; y < regions.mask.rows; ++y) {
    for (int x = 0; x < regions.mask.cols; ++x) {
      const int surface_class = regions.mask(y, x);
      const auto label = static_cast<size_t>(regions.segments.labels(y, x));
      if (surface_class == kGrassClass) {
        grass[label] += 1.0;
      } else if (surface_class != kUnlabelledClass && surface_class != kDormantGrassClass) {
        other[label] += 1.0;
      }
    }
  }
  double covered = 0.0;
  for (size_t label = 1; label < grass.size(); ++label) {
    AddRegion(grass[label], other[label], tally);
    covered += grass[label];
  }
  if (covered + grass[0] == 0.0) return;
  tally.covered_sum += covered / (covered + grass[0]);
  ++tally.num_photographs_with_grass;
}

Json AsJson(const Tally& tally) {
  return {{"covered", Ratio(tally.covered_sum, tally.num_photographs_with_grass)},
          {"purity", Ratio(tally.agreeing, tally.labelled)},
          {"grass_purity", Ratio(tally.grass_region_agreeing, tally.grass_region_labelled)}};
}

}  // namespace

std::vector<Answer> AnswersOf(const Photographs& photographs, const Classifier& classifier) {
  std::vector<Answer> answers;
  for (const LabelledPhotograph& photograph : photographs) {
    const LabelledRegions regions = CutPhotograph(photograph, SegmentationOptions{}, kAnyLabel);
    const Labels labels = ClassifySegments(regions.segments, classifier, ClassificationOptions{});
    for (size_t i = 0; i < labels.size(); ++i) {
      const std::string where =
          photograph.name + " " + std::to_string(regions.segments.segments[i].label);
      answers.push_back({where, photograph.place, labels[i], regions.classes[i]});
    }
  }
  return answers;
}

Json Scores(const std::vector<Answer>& all) {
  const std::vector<Answer> answers = Where(all, IsLabelled);
  int num_wrong = 0, num_unsure = 0, num_grass = 0, num_called = 0, num_right = 0;
  for (const Answer& answer : answers) {
    num_unsure += answer.label.surface == Surface::kUnsure ? 1 : 0;
    num_wrong += IsCalledGrass(answer) != IsGrass(answer) ? 1 : 0;
    num_grass += IsGrass(answer) ? 1 : 0;
    num_called += IsCalledGrass(answer) ? 1 : 0;
    num_right += IsCalledGrass(answer) && IsGrass(answer) ? 1 : 0;
  }
  const auto num_regions = static_cast<int>(answers.size());
  return {{"num_regions", num_regions},
          {"error", Ratio(num_wrong, num_regions)},
          {"auc", AreaUnderCurve(answers)},
          {"precision", Ratio(num_right, num_called)},
          {"recall", Ratio(num_right, num_grass)},
          {"num_unsure", num_unsure},
          {"false_grass", Ratio(num_called - num_right, num_regions - num_grass)},
          {"by_class", CalledGrassByClass(all)}};
}

Json ScoresByPlace(const std::vector<Answer>& answers) {
  std::set<std::string> places;
  for (const Answer& answer : answers) places.insert(answer.place);
  Json scores;
  scores["all"] = Scores(answers);
  for (const std::string& place : places) {
    scores[place] =
        Scores(Where(answers, [&](const Answer& answer) { return answer.place == place; }));
  }
  return scores;
}

Json FalseGrass(const std::vector<Answer>& answers) {
  Json regions = Json::array();
  for (const Answer& answer : answers) {
    if (!IsLabelled(answer) || IsGrass(answer) || !IsCalledGrass(answer)) continue;
    regions.push_back({{"region", answer.where},
                       {"class", kClassNames[static_cast<size_t>(answer.surface_class)]},
                       {"probability", answer.label.probability}});
  }
  return regions;
}

std::vector<Answer> AnswersOfUnseenPlaces(const Photographs& photographs,
                                          const std::vector<TrainingSample>& samples,
                                          const TrainingOptions& options) {
  std::set<std::string> places;
  for (const TrainingSample& sample : samples) places.insert(sample.place);
  std::vector<Answer> answers;
  if (places.size() < 2) return answers;
  for (const std::string& place : places) {
    std::vector<TrainingSample> others;
    std::copy_if(samples.begin(), samples.end(), std::back_inserter(others), [&](const auto& s) {
      return s.place != place;
    });
    Photographs unseen;
    std::copy_if(photographs.begin(),
                 photographs.end(),
                 std::back_inserter(unseen),
                 [&](const auto& photograph) { return photograph.place == place; });
    const Classifier classifier = TrainClassifier(others, "", options).first;
    const std::vector<Answer> some = AnswersOf(unseen, classifier);
    answers.insert(answers.end(), some.begin(), some.end());
  }
  return answers;
}

Json SegmentationScores(const Photographs& photographs, const SegmentationOptions& options) {
  Tally all;
  std::map<std::string, Tally> by_place;
  for (const LabelledPhotograph& photograph : photographs) {
    const LabelledRegions regions = CutPhotograph(photograph, options, kAnyLabel);
    AddPhotograph(regions, all);
    AddPhotograph(regions, by_place[photograph.place]);
  }
  Json scores;
  scores["all"] = AsJson(all);
  for (const auto& [place, tally] : by_place) scores[place] = AsJson(tally);
  return scores;
}

}  // namespace freelsd
