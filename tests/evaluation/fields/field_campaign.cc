#include "tests/evaluation/fields/field_campaign.h"

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <mutex>
#include <set>
#include <stdexcept>

#include "api/flight_parts.h"
#include "tests/evaluation/campaign.h"
#include "tests/evaluation/engine_run.h"
#include "tests/evaluation/fields/field_records.h"
#include "tests/evaluation/synthetic_flight.h"

namespace freelsd {
namespace {

using Json = nlohmann::json;
using SurveyKey = std::pair<std::string, std::string>;

SurveyKey KeyOf(const Json& record) { return {record.at("flight"), record.at("aircraft")}; }

void Sort(Json& records) {
  std::sort(records.begin(), records.end(), [](const Json& a, const Json& b) {
    return KeyOf(a) < KeyOf(b);
  });
}

Json ReportOf(const Json& settings, Json records) {
  Sort(records);
  return {{"settings", settings}, {"surveys", std::move(records)}};
}

Json SettingsOf(const FieldCampaignOptions& options) {
  Json blindings = Json::array();
  for (const Blinding blinding : options.blindings) blindings.push_back(NameOf(blinding));
  Json settings{{"blindings", blindings}};
  if (!options.engine_options.empty()) settings["options"] = options.engine_options;
  return settings;
}

std::string NameOfFlight(const std::string& folder) {
  const std::filesystem::path path(folder);
  return (path.has_filename() ? path : path.parent_path()).filename().string();
}

Json ReadRecords(const FieldCampaignOptions& options) {
  if (!options.resumes) return Json::array();
  return ReadReportToContinue(options.json, SettingsOf(options)).value("surveys", Json::array());
}

// Gives out flights and takes records, to and from several threads.
class Campaign {
 public:
  explicit Campaign(const FieldCampaignOptions& options)
      : options_(options), records_(ReadRecords(options)) {
    for (const Json& record : records_) done_.insert(KeyOf(record));
  }

  Json Run() {
    DoAll(options_.flights.size(), options_.num_jobs, [&](size_t i) { Fly(options_.flights[i]); });
    return ReportOf(SettingsOf(options_), records_);
  }

 private:
  void Fly(const std::string& folder) {
    const std::string name = NameOfFlight(folder);
    const std::string labels = (std::filesystem::path(options_.labels) / (name + ".txt")).string();
    const std::vector<Outline> outlines = ParseOutlines(ReadTextFile(labels), labels);
    const GroundModel model = ReadGroundModel(options_.ModelFileOf(name)).model;
    std::optional<RecordedFrames> frames;
    for (const std::string& profile : options_.aircraft) {
      if (done_.contains({name, profile})) continue;
      if (!frames) frames = ReadRecordedFrames(folder);
      const FieldSurvey survey = SurveyFields({name,
                                               *frames,
                                               outlines,
                                               *AircraftProfile(profile),
                                               options_.blindings,
                                               ParseOptions(options_.engine_options, "")},
                                              model);
      Keep(RecordOf(survey));
    }
  }

  void Keep(Json record) {
    const std::lock_guard<std::mutex> lock(mutex_);
    std::cerr << record.at("flight").get<std::string>() << ", "
              << record.at("aircraft").get<std::string>() << ": " << record.at("counts").dump()
              << std::endl;
    records_.push_back(std::move(record));
    Sort(records_);
    if (options_.json.empty()) return;
    WriteTextFile(options_.json, ReportOf(SettingsOf(options_), records_).dump(1) + "\n");
  }

  const FieldCampaignOptions& options_;
  // Guards records_, which the jobs share, and the file of the records.
  std::mutex mutex_;
  Json records_;
  // What the report to continue from holds. It does not change during the run.
  std::set<SurveyKey> done_;
};

}  // namespace

std::string FieldCampaignOptions::ModelFileOf(const std::string& flight) const {
  if (!model.empty()) return model;
  const PipelineOptions options = ParseOptions(engine_options, "");
  const std::optional<std::string> fold = FoldModelOf(flight);
  return fold && options.preset != Preset::kPaper ? *fold : ModelFileFor(options);
}

void FieldCampaignOptions::Check() const {
  if (resumes && json.empty()) throw std::invalid_argument("--resume needs --json");
  for (const std::string& name : aircraft) {
    if (!AircraftProfile(name)) throw std::invalid_argument("--aircraft: no profile " + name);
  }
  PoolOfRun run;
  for (const std::string& folder : flights) {
    const std::string name = NameOfFlight(folder);
    run.Add("flight " + name, EvaluationPools().Of("flight", name));
  }
}

Json RunFieldCampaign(const FieldCampaignOptions& options) {
  options.Check();
  cv::setNumThreads(1);
  return Campaign(options).Run();
}

}  // namespace freelsd
