// freelsd-eval: the whole engine over seeded worlds whose truth is known; one table, and JSON.
#include <exception>
#include <iostream>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "tests/evaluation/campaign.h"
#include "tests/evaluation/given/given_run.h"
#include "tests/evaluation/report.h"
#include "tests/evaluation/scores/blinding.h"

namespace freelsd {
namespace {

using Json = nlohmann::json;

struct Arguments {
  CampaignOptions campaign;
  // "": the one that belongs to the options.
  std::string model;
  // Limits of the exit status; negative: none.
  int max_false_safe = -1;
  double min_found_ratio = -1.0;
};

// Status 3 where a limit is passed: the run itself went well.
int StatusOf(const Arguments& arguments, const Json& safety) {
  int status = 0;
  const int64_t num_false_safe = safety.at("num_false_safe").get<int64_t>();
  if (arguments.max_false_safe >= 0 && num_false_safe > arguments.max_false_safe) {
    std::cerr << "freelsd-eval: " << num_false_safe << " sites are false safe, at most "
              << arguments.max_false_safe << " may be\n";
    status = 3;
  }
  const Json& found = safety.at("fields_found_ratio");
  if (arguments.min_found_ratio >= 0.0 && found.is_number() &&
      found.get<double>() < arguments.min_found_ratio) {
    std::cerr << "freelsd-eval: " << found << " of the fields were found, at least "
              << arguments.min_found_ratio << " must be\n";
    status = 3;
  }
  return status;
}

int Run(const Arguments& arguments) {
  const std::string model =
      arguments.model.empty() ? arguments.campaign.ModelFile() : arguments.model;
  const Json report = RunCampaign(arguments.campaign, ReadGroundModel(model).model);
  std::cout << TableOf(report);
  return report.contains("safety") ? StatusOf(arguments, report.at("safety")) : 0;
}

void AddScenarioOptions(CLI::App& app, ScenarioOptions& scenario) {
  app.add_option("--noise", scenario.noise_scale, "scale of the autopilot's errors")
      ->check(CLI::Range(0.0, 10.0));
  app.add_option("--damage", scenario.damaged_ratio, "share of photographs damaged")
      ->check(CLI::Range(0.0, 1.0));
  app.add_flag("--on-truth{false}",
               scenario.takes_photographs,
               "plan on maps without error instead: what the rules allow");
  app.add_flag("--give-wires",
               scenario.gives_wires,
               "give the planner the power lines, 2 m exact, as obstacles");
  app.add_option("--frames",
                 scenario.num_frames,
                 "photographs per world; by default 50 at 30 m, 72 at 13 m, 156 at 6 m")
      ->check(CLI::Range(3, 300));
  app.add_option_function<std::string>(
         "--spacing",
         [&scenario](const std::string& spacing) {
           scenario.frame_spacing_m =
               spacing == "mix" ? std::nullopt : std::optional<double>(std::stod(spacing));
         },
         "metres between photographs; mix, the default, takes 6, 13 and 30 in turns")
      ->check(CLI::Range(3.0, 100.0) | CLI::IsMember({"mix"}));
  app.add_option("--size", scenario.world_size_m, "side of a world in metres")
      ->check(CLI::Range(100.0, 1000.0));
  app.add_option(
      "--ground",
      scenario.ground,
      "real ground: a pack of FREELSD_DATA/terrain, or tuning or report for all of a pool");
  app.add_option("--texture", scenario.texture, "painted, or recorded on photographs")
      ->check(CLI::IsMember({"painted", "recorded"}));
  app.add_option("--conditions",
                 scenario.conditions,
                 "light, air and camera: plain, or as recorded flights show them")
      ->check(CLI::IsMember({"plain", "recorded"}));
  app.add_option("--cell", scenario.cell_size_m, "texture of a world in metres")
      ->check(CLI::Range(0.1, 1.0));
  app.add_option("--height", scenario.height_m, "height of flight in metres")
      ->check(CLI::Range(30.0, 400.0));
  app.add_option("--aircraft", scenario.aircraft, "both takes turns")
      ->check(CLI::IsMember({"both", "techpod", "small", "atlantiksolar"}));
  app.add_option("--threads", scenario.num_threads, "threads per world; no result depends on them")
      ->check(CLI::Range(1, 64));
}

void AddOptions(CLI::App& app, Arguments& arguments) {
  CampaignOptions& campaign = arguments.campaign;
  app.add_option("--worlds", campaign.num_worlds, "number of worlds")->check(CLI::Range(1, 100000));
  app.add_option("--seed", campaign.seed, "seed of the first world; the others follow");
  app.add_option("--jobs", campaign.num_jobs, "worlds at once; no result depends on it")
      ->check(CLI::Range(1, 64));
  app.add_option("--json", campaign.json, "report to write, after every world");
  app.add_flag("--resume", campaign.resumes, "go on from the report: its seeds are not run again");
  app.add_option_function<std::string>(
      "--options",
      [&campaign](const std::string& path) {
        campaign.engine_options = Json::parse(ReadTextFile(path));
      },
      "JSON file with options of the engine: {preset: name, stage: {field: value}}");
  app.add_flag("--heights-only",
               campaign.is_heights_only,
               "end with the map: scores its heights and poses, plans nothing");
  app.add_option("--given",
                 campaign.given,
                 "what of the truth the engine is given: poses, kinds, heights, wind; several with "
                 "commas")
      ->delimiter(',')
      ->check(CLI::IsMember(NamesOfGiven()));
  std::vector<std::string> blindings = BlindingNames();
  blindings.emplace_back("each");
  app.add_option("--blind",
                 campaign.blind,
                 "make the map wrong on purpose: judges the judge; each: besides the usual scores")
      ->check(CLI::IsMember(blindings));
  app.add_option_function<std::string>(
      "--ablate",
      [&campaign](const std::string& path) {
        campaign.ablations = Json::parse(ReadTextFile(path));
      },
      "JSON file with steps of the engine to leave out in turn, besides (ablation/ablations.json)");
  app.add_option("--model", arguments.model, "model of the ground, instead of the options' own");
  app.add_option("--max-false-safe", arguments.max_false_safe, "limit of the exit status");
  app.add_option("--min-found-ratio", arguments.min_found_ratio, "limit of the exit status");
}

}  // namespace
}  // namespace freelsd

int main(int argc, char** argv) {
  try {
    freelsd::Arguments arguments;
    arguments.campaign.scenario.frame_spacing_m = std::nullopt;
    CLI::App app(
        "Scores the engine over seeded worlds whose truth is known. Status 3: a limit was passed.");
    freelsd::AddOptions(app, arguments);
    freelsd::AddScenarioOptions(app, arguments.campaign.scenario);
    CLI11_PARSE(app, argc, argv);
    return freelsd::Run(arguments);
  } catch (const std::exception& error) {
    std::cerr << "freelsd-eval: " << error.what() << "\n";
    return 1;
  }
}
