// freelsd-train: trains the paper's classifier on labelled photographs, measures the segmentation,
// and draws sheets for labelling.

#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "engine/pipeline.h"
#include "server/training/label_sheets.h"
#include "server/training/paper_training.h"
#include "server/training/pools.h"
#include "server/training/segmentation_scores.h"

namespace freelsd {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kSheetWidthPx = 1000;

// Default paths are relative to the repository's root.
struct Arguments {
  std::string data;
  std::string flights;
  std::string flight;
  std::string labels = "tests/evaluation/labels";
  std::string out;
  std::string cameras = "tests/evaluation/grass_cameras.csv";
  std::string pools = "tests/evaluation/pools.csv";
  double min_area_m2 = 30.0;
  int seed = 1;
};

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

std::string Provenance(int seed, size_t num_samples) {
  return "Random forest for grass or not, features " + NameOf(FeatureSet::kPaper18) + ", seed " +
         std::to_string(seed) + ", " + std::to_string(num_samples) +
         " regions of labelled photographs of Swindale (vesnikos and supervisor, "
         "acknowledged as asked), Garfield Park (CC0 1.0), Brighton Beach (BSD 2-Clause, (c) 2017 "
         "Piero Toffanin). How it was made and what it scores: paper_model.md.";
}

// Throws std::invalid_argument if they must not train a model.
Photographs ReadTrainingPhotographs(const Arguments& arguments) {
  Photographs photographs = ReadPhotographs(arguments);
  if (PoolOf(photographs, Pools::Read(arguments.pools)) == Pool::kReport) {
    throw std::invalid_argument("photographs of the pool report judge a model and never train one");
  }
  return photographs;
}

int TrainAsPublished(const Arguments& arguments) {
  const std::vector<TrainingSample> samples = PaperSamples(ReadTrainingPhotographs(arguments));
  const std::string provenance = Provenance(arguments.seed, samples.size());
  TrainingOptions options;
  options.seed = arguments.seed;
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
  for (const auto& path : FlightPaths(arguments.flights, arguments.flight)) {
    const LabelledPhotograph photograph = ReadFlightPhotograph(path, arguments.flight, cameras);
    const Segments segments =
        SegmentFrame(photograph.image, photograph.camera, photograph.height_above_ground, options);
    table << RegionRows(photograph, segments);
    const std::string sheet = arguments.out + "/" + photograph.name + ".png";
    if (!cv::imwrite(sheet, RegionSheet(photograph, segments, kSheetWidthPx))) {
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
  CLI::App app("Trains the paper's grass classifier, and helps to label photographs.");
  app.require_subcommand(1);
  Arguments arguments;
  CLI::App* paper = app.add_subcommand("paper", "Trains and validates the paper's classifiers");
  AddPhotographOptions(*paper, arguments);
  paper->add_option("--out", arguments.out, "Model file to write")->required();
  paper->add_option("--seed", arguments.seed, "Seed of folds and models")->capture_default_str();
  CLI::App* segmentation =
      app.add_subcommand("segmentation", "Prints how regions cover the labelled grass");
  AddPhotographOptions(*segmentation, arguments);
  CLI::App* sheets = app.add_subcommand("sheets", "Draws numbered regions for labelling by eye");
  AddPhotographOptions(*sheets, arguments);
  sheets->add_option("--flight", arguments.flight, "Folder within --flights")->required();
  sheets->add_option("--out", arguments.out, "Folder for the sheets and the table")->required();
  sheets->add_option("--min-area", arguments.min_area_m2, "Least area of a region, square metres")
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  if (paper->parsed()) return TrainAsPublished(arguments);
  if (segmentation->parsed()) return MeasureSegmentation(arguments);
  return DrawSheets(arguments);
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
