// freelsd-survey: what each stage of the engine costs on recorded flights; a table in Markdown.
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <sstream>

#include <CLI/CLI.hpp>

#include "tests/evaluation/recorded/recorded_flight.h"

namespace freelsd {
namespace {

namespace fs = std::filesystem;

Classifier ReadClassifier(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error("cannot read " + path);
  std::ostringstream text;
  text << file.rdbuf();
  return Classifier::Parse(text.str());
}

void Run(const std::vector<std::string>& folders, const std::string& model) {
  const Classifier classifier = ReadClassifier(model);
  std::puts("| flight | photographs | stage | times | seconds |\n|---|---|---|---|---|");
  for (const std::string& folder : folders) {
    const std::string name = fs::path(folder).filename().string();
    const RecordedFrames flight = ReadRecordedFrames(folder);
    const Evaluation evaluation =
        Detect(flight.rig, flight.frames, Aircraft{}, PipelineOptions{}, classifier);
    std::map<std::string, std::pair<int, double>> stages;
    for (const StageReport& report : evaluation.reports) {
      auto& [num_times, seconds] = stages[report.stage];
      num_times += 1;
      seconds += report.seconds;
    }
    for (const auto& [stage, cost] : stages) {
      std::printf("| %s | %zu | %s | %d | %.2f |\n",
                  name.c_str(),
                  flight.frames.size(),
                  stage.c_str(),
                  cost.first,
                  cost.second);
    }
  }
}

}  // namespace
}  // namespace freelsd

int main(int argc, char** argv) {
  try {
    CLI::App app{"Prints what each stage of the engine costs on recorded flights, as Markdown."};
    std::vector<std::string> folders;
    std::string model = FREELSD_SOURCE_DIR "/engine/classification/grass_model.yml";
    app.add_option("FLIGHT", folders, "folders with images/ and perhaps poses.csv")
        ->required()
        ->check(CLI::ExistingDirectory);
    app.add_option("--model", model, "the classifier")->check(CLI::ExistingFile);
    CLI11_PARSE(app, argc, argv);
    freelsd::Run(folders, model);
  } catch (const std::exception& error) {
    std::cerr << "freelsd-survey: " << error.what() << "\n";
    return 1;
  }
  return 0;
}
