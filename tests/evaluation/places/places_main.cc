// freelsd-places: judges a grass classifier on labelled photographs of places that no model has
// seen. Prints tables in Markdown.
#include <cstdlib>
#include <exception>
#include <iostream>

#include <CLI/CLI.hpp>

#include "tests/evaluation/campaign.h"
#include "tests/evaluation/places/place_report.h"
#include "tests/evaluation/places/place_run.h"
#include "tests/evaluation/places/place_variation.h"

namespace freelsd {
namespace {

constexpr int kWorseThanChanceStatus = 3;

struct Arguments {
  PlaceRunOptions run;
  std::vector<std::string> merged;
  std::string blind;
};

void AddOptions(CLI::App& app, Arguments& arguments) {
  PlaceRunOptions& run = arguments.run;
  const std::string folder = FREELSD_SOURCE_DIR "/tests/evaluation/places/";
  const char* data = std::getenv("FREELSD_DATA");
  run.photographs = data == nullptr ? "" : std::string(data) + "/places";
  run.labels = folder + "labels";
  run.cameras = folder + "cameras.csv";
  run.model = FREELSD_SOURCE_DIR "/engine/classification/grass_model.yml";
  app.add_option("--photographs", run.photographs, "folder with a folder per place");
  app.add_option("--labels", run.labels, "folder with PLACE.txt for every place");
  app.add_option("--cameras", run.cameras, "ground scale of the photographs");
  app.add_option("--model", run.model, "the classifier")->check(CLI::ExistingFile);
  app.add_option("--place", run.places, "judges only these places");
  app.add_option(
      "--variation", run.variations, "none, cast, dark, blur, haze, or all of them: all");
  app.add_option("--jobs", run.num_jobs, "photographs at once");
  app.add_option("--json", run.json, "the report, written after every photograph");
  app.add_flag("--resume", run.resumes, "continues from the report of --json");
  app.add_option("--merge", arguments.merged, "merges these reports and judges nothing")
      ->check(CLI::ExistingFile);
  app.add_option("--pictures", run.pictures, "folder for pictures of the answers");
  app.add_option("--blind", arguments.blind, "kinds: swaps grass and not grass in every answer")
      ->check(CLI::IsMember({"kinds"}));
}

nlohmann::json MergedReport(const Arguments& arguments) {
  std::vector<nlohmann::json> reports;
  reports.reserve(arguments.merged.size());
  for (const std::string& path : arguments.merged) {
    reports.push_back(nlohmann::json::parse(ReadTextFile(path)));
  }
  nlohmann::json report = MergePlaceReports(reports);
  if (!arguments.run.json.empty()) WriteTextFile(arguments.run.json, report.dump(1) + "\n");
  return report;
}

nlohmann::json ReportOf(Arguments arguments) {
  if (!arguments.merged.empty()) return MergedReport(arguments);
  if (arguments.run.photographs.empty()) {
    throw std::runtime_error("set FREELSD_DATA or give --photographs");
  }
  arguments.run.swaps_kinds = !arguments.blind.empty();
  if (arguments.run.variations == std::vector<std::string>{"all"}) {
    arguments.run.variations = PlaceVariationNames();
  }
  return RunPlaces(arguments.run);
}

int Run(const Arguments& arguments) {
  const nlohmann::json report = ReportOf(arguments);
  std::cout << PlaceReportAsMarkdown(report);
  if (IsBetterThanChance(report)) return 0;
  std::cerr << "freelsd-places: the pooled answers are worse than chance (AUC below 0.5)\n";
  return kWorseThanChanceStatus;
}

}  // namespace
}  // namespace freelsd

int main(int argc, char** argv) {
  try {
    CLI::App app{"Judges a grass classifier on labelled photographs of places it has not seen."};
    freelsd::Arguments arguments;
    freelsd::AddOptions(app, arguments);
    CLI11_PARSE(app, argc, argv);
    return freelsd::Run(arguments);
  } catch (const std::exception& error) {
    std::cerr << "freelsd-places: " << error.what() << "\n";
    return 1;
  }
}
