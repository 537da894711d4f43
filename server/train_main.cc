// freelsd-train: trains the grass classifier from labelled photographs, and evaluates a model.

#include <cstdio>
#include <exception>
#include <fstream>
#include <iostream>
#include <sstream>
#include <stdexcept>
#include <string>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "engine/pipeline.h"
#include "server/training_data.h"

namespace freelsd {
namespace {

constexpr double kTileM = 10.0;
// A region counts with its majority label when at least this share of it is labelled.
constexpr double kMinLabelledRatio = 0.5;

struct Arguments {
  std::string data;
  std::string out = "grass_model.yml";
  std::string model = FREELSD_SOURCE_DIR "/engine/classification/grass_model.yml";
  std::string cameras = FREELSD_SOURCE_DIR "/tests/evaluation/grass_cameras.csv";
  std::string features = "robust";
  int seed = 1;
};

std::string ReadFile(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error("cannot read " + path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

int Train(const Arguments& arguments) {
  const std::optional<FeatureSet> feature_set = FeatureSetNamed(arguments.features);
  if (!feature_set) throw std::runtime_error("unknown feature set " + arguments.features);
  std::vector<TrainingSample> samples;
  for (const LabelledPhotograph& photograph :
       ReadLabelledPhotographs(arguments.data, ReadLabelledCameras(arguments.cameras))) {
    for (TrainingSample& sample :
         RegionSamples(photograph, *feature_set, kMinLabelledRatio, Augmentation::kPhotometric)) {
      samples.push_back(std::move(sample));
    }
    for (TrainingSample& sample :
         TileSamples(photograph, *feature_set, kTileM, Augmentation::kPhotometric)) {
      samples.push_back(std::move(sample));
    }
  }
  TrainingOptions options;
  options.feature_set = *feature_set;
  options.seed = arguments.seed;
  const std::string provenance =
      "Random forest, features " + arguments.features + ", " + std::to_string(samples.size()) +
      " samples (regions and 10 m tiles, each in seven exposures and colours of light) of labelled "
      "photographs of Swindale (vesnikos and "
      "supervisor), Garfield Park (CC0 1.0) and Brighton Beach (BSD 2-Clause, Piero Toffanin). "
      "See grass_model.md.";
  const auto [classifier, report] = TrainClassifier(samples, provenance, options);
  std::ofstream(arguments.out, std::ios::binary) << classifier.Serialize();
  std::cout << nlohmann::ordered_json{{"model", arguments.out},
                                      {"features", arguments.features},
                                      {"num_samples", samples.size()},
                                      {"max_depth", report.max_depth},
                                      {"min_samples_per_branch", report.min_samples_per_branch},
                                      {"random_fold_error", report.random_fold_error_ratio},
                                      {"leave_one_place_out_error",
                                       report.leave_one_place_out_error_ratio},
                                      {"leave_one_place_out_auc", report.leave_one_place_out_auc}}
                   .dump(2)
            << "\n";
  return 0;
}

// Counts of a model's answers on regions, as JSON.
nlohmann::ordered_json Scores(const Classifier& classifier,
                              const std::vector<TrainingSample>& samples) {
  const ClassificationOptions options;
  std::vector<std::pair<double, bool>> answers;
  int num_wrong = 0, num_unsure = 0, true_grass = 0, called_grass = 0, right_grass = 0;
  for (const TrainingSample& sample : samples) {
    const double probability = classifier.Predict(sample.features);
    answers.emplace_back(probability, sample.is_grass);
    // Unsure counts as not grass.
    const bool is_called_grass = probability >= options.min_grass_probability;
    num_unsure += !is_called_grass && probability > options.max_not_grass_probability ? 1 : 0;
    num_wrong += is_called_grass != sample.is_grass ? 1 : 0;
    true_grass += sample.is_grass ? 1 : 0;
    called_grass += is_called_grass ? 1 : 0;
    right_grass += is_called_grass && sample.is_grass ? 1 : 0;
  }
  double in_order = 0.0, pairs = 0.0;
  for (const auto& [grass, is_grass] : answers) {
    for (const auto& [other, is_other_grass] : answers) {
      if (!is_grass || is_other_grass) continue;
      pairs += 1.0;
      in_order += grass > other ? 1.0 : grass == other ? 0.5 : 0.0;
    }
  }
  const auto ratio = [](double part, double whole) {
    return whole > 0.0 ? nlohmann::ordered_json(part / whole) : nlohmann::ordered_json(nullptr);
  };
  return {{"num_regions", samples.size()},
          {"error", ratio(num_wrong, static_cast<double>(samples.size()))},
          {"auc", ratio(in_order, pairs)},
          {"precision", ratio(right_grass, called_grass)},
          {"recall", ratio(right_grass, true_grass)},
          {"num_unsure", num_unsure}};
}

int Evaluate(const Arguments& arguments) {
  const Classifier classifier = Classifier::Parse(ReadFile(arguments.model));
  // Any labelled pixel gives a region its majority.
  constexpr double kAnyLabel = 1e-9;
  std::vector<TrainingSample> samples;
  for (const LabelledPhotograph& photograph :
       ReadLabelledPhotographs(arguments.data, ReadLabelledCameras(arguments.cameras))) {
    for (TrainingSample& sample :
         RegionSamples(photograph, classifier.feature_set(), kAnyLabel, Augmentation::kNone)) {
      samples.push_back(std::move(sample));
    }
  }
  std::cout << Scores(classifier, samples).dump(2) << "\n";
  return 0;
}

int Run(int argc, char** argv) {
  CLI::App app("Trains the grass classifier of freelsd, or evaluates a model (subcommand).");
  Arguments arguments;
  app.add_option("--data", arguments.data, "Folder with images/ and masks/");
  app.add_option("--out", arguments.out, "Model file to write")->capture_default_str();
  app.add_option("--features", arguments.features, "rgb, hsv, rgbhsv, paper18 or robust")
      ->capture_default_str();
  app.add_option("--cameras", arguments.cameras, "Scale of the photographs, CSV")
      ->capture_default_str();
  app.add_option("--seed", arguments.seed, "Of the forest")->capture_default_str();
  CLI::App* evaluate = app.add_subcommand("evaluate", "Prints a model's scores on regions");
  evaluate->add_option("--data", arguments.data, "Folder with images/ and masks/")->required();
  evaluate->add_option("--model", arguments.model, "Model file")->capture_default_str();
  evaluate->add_option("--cameras", arguments.cameras, "Scale of the photographs, CSV")
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  if (evaluate->parsed()) return Evaluate(arguments);
  if (arguments.data.empty()) throw std::runtime_error("--data is needed");
  return Train(arguments);
}

}  // namespace
}  // namespace freelsd

int main(int argc, char** argv) {
  try {
    return freelsd::Run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "freelsd-train: %s\n", error.what());
    return 1;
  }
}
