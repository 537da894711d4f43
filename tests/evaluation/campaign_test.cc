// Runs in parts: gone on with, put together, several worlds at once.
#include "tests/evaluation/campaign.h"

#include <cstdlib>
#include <filesystem>
#include <stdexcept>

#include <doctest/doctest.h>
#include <unistd.h>

#include "tests/evaluation/report.h"

namespace freelsd {
namespace {

using Json = nlohmann::json;

// As small as a flight can be; whether anything is found is not asked.
CampaignOptions Tiny(const std::string& json) {
  CampaignOptions options;
  options.num_worlds = 1;
  options.seed = 1010;
  options.scenario.world_size_m = 200.0;
  options.scenario.cell_size_m = 0.5;
  options.scenario.num_frames = 3;
  options.scenario.aircraft = "small";
  options.json = json;
  return options;
}

Classifier RealClassifier() {
  return Classifier::Parse(
      ReadTextFile(FREELSD_SOURCE_DIR "/engine/classification/grass_model.yml"));
}

struct TemporaryFile {
  std::filesystem::path path = std::filesystem::temp_directory_path() /
                               ("freelsd-campaign-" + std::to_string(getpid()) + ".json");
  ~TemporaryFile() { std::filesystem::remove(path); }
};

TEST_CASE(
    "campaign: a run goes on where it ended, several worlds at once, and parts are put together") {
  const TemporaryFile file;
  const Classifier classifier = RealClassifier();
  CampaignOptions options = Tiny(file.path.string());
  Json first = RunCampaign(options, classifier);
  REQUIRE(first.at("worlds").size() == 1);
  CHECK(first.at("cpu_s_per_world").at("photographs").get<double>() > 0.0);
  // A mark tells whether the world was flown again.
  first.at("worlds").at(0)["mark"] = 1;
  WriteTextFile(options.json, first.dump());
  options.num_worlds = 2;
  options.num_jobs = 2;
  options.resumes = true;
  const Json both = RunCampaign(options, classifier);
  REQUIRE(both.at("worlds").size() == 2);
  CHECK(both.at("worlds").at(0).contains("mark"));
  CHECK(both.at("worlds").at(1).at("seed") == 1011);
  CHECK(Json::parse(ReadTextFile(options.json)).at("worlds") == both.at("worlds"));

  Json second = both;
  second.at("worlds").erase(0);
  const Json merged = MergeReports({second, first});
  CHECK(merged.at("worlds") == both.at("worlds"));
  CHECK(merged.at("safety") == both.at("safety"));
  CHECK_THROWS_WITH_AS(
      MergeReports({both, second}), "seed 1011 is in two reports", std::runtime_error);
  second.at("settings")["noise_scale"] = 2.0;
  CHECK_THROWS_AS(MergeReports({first, second}), std::runtime_error);
  CHECK_THROWS_AS(MergeReports({}), std::runtime_error);

  options.scenario.noise_scale = 2.0;
  CHECK_THROWS_AS(RunCampaign(options, classifier), std::runtime_error);
}

TEST_CASE("campaign: Check names what does not go together") {
  CampaignOptions options = Tiny("");
  options.resumes = true;
  CHECK_THROWS_WITH_AS(options.Check(), "--resume needs --json", std::invalid_argument);
  options = Tiny("");
  options.num_jobs = 2;
  options.scenario.num_threads = 2;
  CHECK_THROWS_AS(options.Check(), std::invalid_argument);
}

}  // namespace
}  // namespace freelsd
