// Work on several threads, and reports that are continued and merged.
#include "tests/evaluation/runs/runs.h"

#include <atomic>
#include <filesystem>
#include <stdexcept>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "tests/evaluation/fields/field_campaign.h"

namespace freelsd {
namespace {

using Json = nlohmann::json;

TEST_CASE("runs: each piece is done once, on one thread or on several") {
  constexpr size_t kNumPieces = 100;
  for (const int num_jobs : {1, 4}) {
    std::vector<std::atomic<int>> counts(kNumPieces);
    DoAll(kNumPieces, num_jobs, [&](size_t i) { ++counts[i]; });
    for (const std::atomic<int>& count : counts) CHECK(count == 1);
  }
}

TEST_CASE("runs: a failure ends the run and reaches the caller") {
  std::atomic<int> num_begun = 0;
  const auto work = [&](size_t i) {
    ++num_begun;
    if (i == 3) throw std::runtime_error("piece 3");
  };
  CHECK_THROWS_WITH_AS(DoAll(1000, 1, work), "piece 3", std::runtime_error);
  CHECK(num_begun == 4);
  CHECK_THROWS_AS(DoAll(1000, 4, work), std::runtime_error);
}

TEST_CASE("runs: reports of other settings are neither continued nor merged") {
  const std::string path = std::filesystem::temp_directory_path() / "freelsd-runs.json";
  const Json report{{"settings", {{"seed", 1}}}, {"worlds", {1, 2}}};
  WriteTextFile(path, report.dump());
  CHECK(ReadReportToContinue(path, report.at("settings")) == report);
  CHECK_THROWS_AS(ReadReportToContinue(path, {{"seed", 2}}), std::runtime_error);
  std::filesystem::remove(path);
  CHECK(ReadReportToContinue(path, {{"seed", 2}}).empty());
  CHECK(SharedSettings({report, report}) == report.at("settings"));
  CHECK_THROWS_AS(SharedSettings({report, {{"settings", {{"seed", 2}}}}}), std::runtime_error);
  CHECK_THROWS_AS(SharedSettings({}), std::runtime_error);
}

TEST_CASE("runs: a slash behind a flight's folder does not hide its pool") {
  FieldCampaignOptions options;
  options.flights = {"flights/swindale/", "flights/seneca_nir/"};
  CHECK_THROWS_WITH_AS(
      options.Check(),
      "flight seneca_nir is of the pool report, but flight swindale is of the pool tuning",
      std::invalid_argument);
}

}  // namespace
}  // namespace freelsd
