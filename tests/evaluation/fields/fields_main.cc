// freelsd-fields: the sites that the engine accepts on recorded flights, scored against outlines
// drawn by eye on the photographs.
#include <exception>
#include <iostream>

#include <CLI/CLI.hpp>

#include "tests/evaluation/campaign.h"
#include "tests/evaluation/fields/field_campaign.h"

namespace freelsd {
namespace {

struct Arguments {
  FieldCampaignOptions campaign;
  std::vector<std::string> blind;
};

void Run(const Arguments& arguments) {
  FieldCampaignOptions options = arguments.campaign;
  for (const std::string& name : arguments.blind) {
    options.blindings.push_back(BlindingNamed(name).value());
  }
  const auto report = RunFieldCampaign(options);
  for (const nlohmann::json& survey : report.at("surveys")) {
    std::cout << survey.at("flight") << ", " << survey.at("aircraft") << ": "
              << survey.at("counts").dump() << "\n";
  }
}

void AddOptions(CLI::App& app, Arguments& arguments) {
  FieldCampaignOptions& campaign = arguments.campaign;
  app.add_option("FLIGHT", campaign.flights, "folders with images/ and perhaps poses.csv")
      ->check(CLI::ExistingDirectory);
  app.add_option("--aircraft", campaign.aircraft, "profiles, separated by commas")->delimiter(',');
  app.add_option("--labels", campaign.labels, "folder with FLIGHT.txt: outlines drawn by eye")
      ->check(CLI::ExistingDirectory);
  app.add_option("--blind",
                 arguments.blind,
                 "also plan on all labelled ground with a part of the map made wrong; names are "
                 "separated by commas")
      ->delimiter(',')
      ->check(CLI::IsMember(BlindingNames()));
  app.add_option("--jobs", campaign.num_jobs, "flights at once; no result depends on it")
      ->check(CLI::Range(1, 64));
  app.add_option("--json", campaign.json, "report to write, after every flight and aircraft");
  app.add_flag(
      "--resume", campaign.resumes, "go on from the report: what is in it is not run again");
  app.add_option_function<std::string>(
      "--options",
      [&campaign](const std::string& path) {
        campaign.engine_options = nlohmann::json::parse(ReadTextFile(path));
      },
      "JSON file with options of the engine: {preset: name, stage: {field: value}}");
  app.add_option("--model", campaign.model, "model of the ground, instead of the fold's")
      ->check(CLI::ExistingFile);
}

}  // namespace
}  // namespace freelsd

int main(int argc, char** argv) {
  try {
    freelsd::Arguments arguments;
    CLI::App app("Scores the sites accepted on recorded flights against outlines drawn by eye.");
    freelsd::AddOptions(app, arguments);
    CLI11_PARSE(app, argc, argv);
    freelsd::Run(arguments);
  } catch (const std::exception& error) {
    std::cerr << "freelsd-fields: " << error.what() << "\n";
    return 1;
  }
  return 0;
}
