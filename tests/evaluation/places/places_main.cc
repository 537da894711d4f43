// freelsd-places: judges a network of ground kinds on labelled photographs of places that no model
// has seen. Prints the pooled figures as JSON.
#include <cstdlib>
#include <exception>
#include <iostream>

#include <CLI/CLI.hpp>

#include "tests/evaluation/places/place_report.h"
#include "tests/evaluation/places/place_run.h"
#include "tests/evaluation/runs/runs.h"

namespace freelsd {
namespace {

constexpr int kWorseThanChanceStatus = 3;

struct Arguments {
  PlaceRunOptions run;
  std::string json;
};

void AddOptions(CLI::App& app, Arguments& arguments) {
  PlaceRunOptions& run = arguments.run;
  const std::string folder = FREELSD_SOURCE_DIR "/tests/evaluation/places/";
  const char* data = std::getenv("FREELSD_DATA");
  run.photographs = data == nullptr ? "" : std::string(data) + "/places";
  run.labels = folder + "labels";
  run.cameras = folder + "cameras.csv";
  app.add_option("--photographs", run.photographs, "folder with a folder per place");
  app.add_option("--labels", run.labels, "folder with PLACE.txt for every place");
  app.add_option("--cameras", run.cameras, "ground scale of the photographs");
  app.add_option("--model",
                 run.model,
                 "network of ground kinds, .onnx, instead of the one of the place's fold")
      ->check(CLI::ExistingFile);
  app.add_option("--place", run.places, "judges only these places");
  app.add_option("--jobs", run.num_jobs, "photographs at once");
  app.add_option("--json", arguments.json, "the whole report");
  app.add_flag("--blind", run.swaps_kinds, "swaps grass and not grass in every answer");
}

int Run(const Arguments& arguments) {
  if (arguments.run.photographs.empty()) {
    throw std::runtime_error("set FREELSD_DATA or give --photographs");
  }
  const nlohmann::json report = RunPlaces(arguments.run);
  if (!arguments.json.empty()) WriteTextFile(arguments.json, report.dump(1) + "\n");
  std::cout << report.at("pooled").dump(1) << "\n";
  if (IsBetterThanChance(report)) return 0;
  std::cerr << "freelsd-places: the pooled answers are worse than chance (AUC below 0.5)\n";
  return kWorseThanChanceStatus;
}

}  // namespace
}  // namespace freelsd

int main(int argc, char** argv) {
  try {
    CLI::App app{
        "Judges a network of ground kinds on labelled photographs of places it has not seen."};
    freelsd::Arguments arguments;
    freelsd::AddOptions(app, arguments);
    CLI11_PARSE(app, argc, argv);
    return freelsd::Run(arguments);
  } catch (const std::exception& error) {
    std::cerr << "freelsd-places: " << error.what() << "\n";
    return 1;
  }
}
