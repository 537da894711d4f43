// freelsd-train: trains the grass classifier on labelled photographs, evaluates a model, measures
// the segmentation, and draws sheets for labelling.

#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "engine/pipeline.h"
#include "server/training/curve_plots.h"
#include "server/training/label_sheets.h"
#include "server/training/paper_training.h"
#include "server/training/pools.h"
#include "server/training/training_data.h"
#include "server/training/training_scores.h"

namespace freelsd {
namespace {

using Json = nlohmann::ordered_json;

// Varied copies of every photograph in the training set.
constexpr int kNumCopies = 3;
constexpr int kSheetWidthPx = 1000;
// A veil of haze: what is left of the light from the ground, and what the air adds, grey levels.
constexpr double kHazeKeptRatio = 0.75;
constexpr double kHazeGrey = 45.0;

// Default paths are relative to the repository's root.
struct Arguments {
  std::string data;
  std::string flights;
  std::string flight;
  std::string labels = "tests/evaluation/labels";
  std::string out = "grass_model.yml";
  std::string model = "engine/classification/grass_model.yml";
  std::string cameras = "tests/evaluation/grass_cameras.csv";
  std::string pools = "tests/evaluation/pools.csv";
  std::string features = "robust";
  std::string plots;
  double min_area_m2 = 30.0;
  bool is_classified = false;
  int seed = 1;
};

std::string ReadFile(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error("cannot read " + path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

void WriteFile(const std::string& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  if (!(file << text << std::flush)) throw std::runtime_error("cannot write " + path);
}

// Throws std::invalid_argument if the photographs are of two pools.
std::optional<Pool> PoolOf(const Photographs& photographs, const Pools& pools) {
  PoolOfRun run;
  for (const LabelledPhotograph& photograph : photographs) {
    run.Add("photograph " + photograph.name, pools.Of("flight", photograph.place));
    run.Add("photograph " + photograph.name, pools.Of("place", photograph.place));
  }
  return run.pool();
}

// Reads photographs with masks from --data, and photographs with tables of labels from --flights.
Photographs ReadPhotographs(const Arguments& arguments) {
  const std::vector<LabelledCamera> cameras = ReadLabelledCameras(arguments.cameras);
  Photographs photographs;
  if (!arguments.data.empty()) photographs = ReadLabelledPhotographs(arguments.data, cameras);
  if (!arguments.flights.empty()) {
    for (auto& photograph : ReadLabelledFlights(arguments.flights, arguments.labels, cameras)) {
      photographs.push_back(std::move(photograph));
    }
  }
  if (photographs.empty()) throw std::runtime_error("--data or --flights is required");
  PoolOf(photographs, Pools::Read(arguments.pools));
  return photographs;
}

Json ReportAsJson(const TrainingReport& report) {
  return {{"max_depth", report.max_depth},
          {"min_samples_per_branch", report.min_samples_per_branch},
          {"random_fold_error", report.random_fold_error_ratio},
          {"leave_one_place_out_error", report.leave_one_place_out_error_ratio},
          {"leave_one_place_out_auc", report.leave_one_place_out_auc}};
}

std::string Provenance(const Arguments& arguments, const std::string& samples, const char* page) {
  return "Random forest for grass or not, features " + arguments.features + ", seed " +
         std::to_string(arguments.seed) + ", " + samples +
         " of labelled photographs of Swindale (vesnikos and supervisor, "
         "acknowledged as asked), Garfield Park (CC0 1.0), Brighton Beach (BSD 2-Clause, (c) 2017 "
         "Piero Toffanin). How it was made and what it scores: " +
         page + ".";
}

// Throws std::invalid_argument if they must not train a model.
Photographs ReadTrainingPhotographs(const Arguments& arguments) {
  Photographs photographs = ReadPhotographs(arguments);
  if (PoolOf(photographs, Pools::Read(arguments.pools)) == Pool::kReport) {
    throw std::invalid_argument("photographs of the pool report judge a model and never train one");
  }
  return photographs;
}

Photographs InHaze(Photographs photographs) {
  for (LabelledPhotograph& photograph : photographs) {
    photograph.image.convertTo(photograph.image, CV_8U, kHazeKeptRatio, kHazeGrey);
  }
  return photographs;
}

int Train(const Arguments& arguments) {
  const std::optional<FeatureSet> feature_set = FeatureSetNamed(arguments.features);
  if (!feature_set) throw std::runtime_error("unknown feature set " + arguments.features);
  Photographs photographs = ReadTrainingPhotographs(arguments);
  const std::vector<TrainingSample> samples =
      SamplesOf(photographs, *feature_set, kNumCopies, arguments.seed);
  const auto num_originals = static_cast<size_t>(std::count_if(
      samples.begin(), samples.end(), [](const auto& sample) { return !sample.is_augmented; }));
  TrainingOptions options;
  options.feature_set = *feature_set;
  options.seed = arguments.seed;
  const std::string provenance = Provenance(
      arguments, std::to_string(num_originals) + " regions and 10 m tiles", "grass_model.md");
  const auto [classifier, report] = TrainClassifier(samples, provenance, options);
  WriteFile(arguments.out, classifier.Serialize());
  const std::vector<Answer> unseen = AnswersOfUnseenPlaces(photographs, samples, options);
  if (!arguments.plots.empty()) WriteFile(arguments.plots, CurvePlots(unseen));
  const std::vector<Answer> in_haze =
      AnswersOfUnseenPlaces(InHaze(std::move(photographs)), samples, options);
  const Json figures{{"model", arguments.out},
                     {"features", arguments.features},
                     {"num_samples", num_originals},
                     {"num_augmented", samples.size() - num_originals},
                     {"samples", ReportAsJson(report)},
                     {"regions_of_unseen_places", ScoresByPlace(unseen)},
                     {"regions_of_unseen_places_in_haze", ScoresByPlace(in_haze)},
                     {"false_grass_at_unseen_places", FalseGrass(unseen)}};
  std::cout << figures.dump(2) << "\n";
  return 0;
}

int TrainAsPublished(Arguments arguments) {
  arguments.features = NameOf(FeatureSet::kPaper18);
  const std::vector<TrainingSample> samples = PaperSamples(ReadTrainingPhotographs(arguments));
  const std::string provenance =
      Provenance(arguments, std::to_string(samples.size()) + " regions", "paper_model.md");
  const TrainingOptions options = PaperTraining(FeatureSet::kPaper18, arguments.seed);
  WriteFile(arguments.out, TrainClassifier(samples, provenance, options).first.Serialize());
  const auto num_grass = std::count_if(
      samples.begin(), samples.end(), [](const TrainingSample& sample) { return sample.is_grass; });
  const Json figures{{"model", arguments.out},
                     {"num_samples", samples.size()},
                     {"num_grass", num_grass},
                     {"scores", PaperScores(samples, arguments.seed)}};
  std::cout << figures.dump(2) << "\n";
  return 0;
}

int Evaluate(const Arguments& arguments) {
  const Classifier classifier = Classifier::Parse(ReadFile(arguments.model));
  const std::vector<Answer> answers = AnswersOf(ReadPhotographs(arguments), classifier);
  Json scores = Scores(answers);
  scores["false_grass_regions"] = FalseGrass(answers);
  std::cout << scores.dump(2) << "\n";
  return 0;
}

int MeasureSegmentation(const Arguments& arguments) {
  const Photographs photographs = ReadPhotographs(arguments);
  SegmentationOptions paper;
  paper.thresholds = SegmentationThresholds::kPaper;
  const Json scores{{"default", SegmentationScores(photographs, SegmentationOptions{})},
                    {"paper", SegmentationScores(photographs, paper)}};
  std::cout << scores.dump(2) << "\n";
  return 0;
}

int DrawSheets(const Arguments& arguments) {
  const std::vector<LabelledCamera> cameras = ReadLabelledCameras(arguments.cameras);
  std::filesystem::create_directories(arguments.out);
  std::ofstream table(arguments.out + "/" + arguments.flight + ".csv");
  table << kLabelTableHeader << "\n";
  SegmentationOptions options;
  options.min_region_area_m2 = arguments.min_area_m2;
  std::optional<Classifier> classifier;
  if (arguments.is_classified) classifier = Classifier::Parse(ReadFile(arguments.model));
  for (const auto& path : FlightPaths(arguments.flights, arguments.flight)) {
    const LabelledPhotograph photograph = ReadFlightPhotograph(path, arguments.flight, cameras);
    const Segments segments =
        SegmentFrame(photograph.image, photograph.camera, photograph.height_above_ground, options);
    table << RegionRows(photograph, segments);
    const std::string sheet = arguments.out + "/" + photograph.name + ".png";
    const Labels labels =
        classifier ? ClassifySegments(segments, *classifier, ClassificationOptions{}) : Labels{};
    if (!cv::imwrite(sheet, RegionSheet(photograph, segments, labels, kSheetWidthPx))) {
      throw std::runtime_error("cannot write " + sheet);
    }
  }
  if (!(table << std::flush)) throw std::runtime_error("cannot write to " + arguments.out);
  return 0;
}

void AddPhotographOptions(CLI::App& command, Arguments& arguments) {
  command.add_option("--data", arguments.data, "Folder with images/ and masks/");
  command.add_option("--flights", arguments.flights, "Folder that contains FLIGHT/images");
  command.add_option("--labels", arguments.labels, "Folder that contains FLIGHT.csv")
      ->capture_default_str();
  command.add_option("--cameras", arguments.cameras, "CSV file with the scale of the photographs")
      ->capture_default_str();
  command.add_option("--pools", arguments.pools, "CSV file: which places may train a model")
      ->capture_default_str();
}

int Run(int argc, char** argv) {
  CLI::App app("Trains the grass classifier of freelsd. Subcommands do the rest.");
  Arguments arguments;
  AddPhotographOptions(app, arguments);
  app.add_option("--out", arguments.out, "Model file to write")->capture_default_str();
  app.add_option(
         "--features", arguments.features, "Feature set: rgb, hsv, rgbhsv, paper18 or robust")
      ->capture_default_str();
  app.add_option(
      "--plots", arguments.plots, "SVG file to write: ROC and precision-recall at unseen places");
  app.add_option("--seed", arguments.seed, "Seed of the forest")->capture_default_str();
  CLI::App* paper = app.add_subcommand("paper", "Trains and validates the paper's classifiers");
  AddPhotographOptions(*paper, arguments);
  paper->add_option("--out", arguments.out, "Model file to write")->required();
  paper->add_option("--seed", arguments.seed, "Seed of folds and models")->capture_default_str();
  CLI::App* evaluate = app.add_subcommand("evaluate", "Prints a model's scores on regions");
  AddPhotographOptions(*evaluate, arguments);
  evaluate->add_option("--model", arguments.model, "Model file")->capture_default_str();
  CLI::App* segmentation =
      app.add_subcommand("segmentation", "Prints how regions cover the labelled grass");
  AddPhotographOptions(*segmentation, arguments);
  CLI::App* sheets = app.add_subcommand("sheets", "Draws numbered regions for labelling by eye");
  AddPhotographOptions(*sheets, arguments);
  sheets->add_option("--flight", arguments.flight, "Folder within --flights")->required();
  sheets->add_option("--out", arguments.out, "Folder for the sheets and the table")->required();
  sheets->add_option("--min-area", arguments.min_area_m2, "Least area of a region, square metres")
      ->capture_default_str();
  sheets->add_flag(
      "--classify", arguments.is_classified, "Colour the regions by their class from --model");
  sheets->add_option("--model", arguments.model, "Model file")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  if (paper->parsed()) return TrainAsPublished(arguments);
  if (evaluate->parsed()) return Evaluate(arguments);
  if (segmentation->parsed()) return MeasureSegmentation(arguments);
  if (sheets->parsed()) return DrawSheets(arguments);
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
