#include "tests/evaluation/fields/field_campaign.h"

#include <algorithm>
#include <exception>
#include <filesystem>
#include <iostream>
#include <mutex>
#include <set>
#include <stdexcept>
#include <thread>

#include "tests/evaluation/campaign.h"
#include "tests/evaluation/fields/field_pictures.h"
#include "tests/evaluation/fields/field_records.h"

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
  return {{"blindings", blindings}};
}

std::string NameOfFlight(const std::string& folder) {
  const std::filesystem::path path(folder);
  return (path.has_filename() ? path : path.parent_path()).filename().string();
}

Json ReadRecords(const FieldCampaignOptions& options) {
  if (!options.resumes || !std::filesystem::exists(options.json)) return Json::array();
  const Json report = Json::parse(ReadTextFile(options.json));
  if (report.at("settings") != SettingsOf(options)) {
    throw std::runtime_error(options.json +
                             " was made with other settings: " + report.at("settings").dump());
  }
  return report.at("surveys");
}

// Gives out flights and takes records, to and from several threads.
class Campaign {
 public:
  Campaign(const FieldCampaignOptions& options, const Classifier& classifier)
      : options_(options), classifier_(classifier), records_(ReadRecords(options)) {
    for (const Json& record : records_) done_.insert(KeyOf(record));
  }

  Json Run() {
    std::vector<std::thread> jobs;
    for (int i = 1; i < options_.num_jobs; ++i) jobs.emplace_back([this] { Work(); });
    Work();
    for (std::thread& job : jobs) job.join();
    if (failure_) std::rethrow_exception(failure_);
    return ReportOf(SettingsOf(options_), records_);
  }

 private:
  // Number of the next flight; that of all flights where none is left.
  size_t Next() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return failure_ ? options_.flights.size() : std::min(next_++, options_.flights.size());
  }

  void Work() {
    try {
      for (size_t i = Next(); i < options_.flights.size(); i = Next()) Fly(options_.flights[i]);
    } catch (...) {  // handed on to the thread that waits
      const std::lock_guard<std::mutex> lock(mutex_);
      if (!failure_) failure_ = std::current_exception();
    }
  }

  void Fly(const std::string& folder) {
    const std::string name = NameOfFlight(folder);
    const std::string labels = (std::filesystem::path(options_.labels) / (name + ".txt")).string();
    const std::vector<Outline> outlines = ParseOutlines(ReadTextFile(labels), labels);
    std::optional<RecordedFrames> frames;
    for (const std::string& profile : options_.aircraft) {
      if (IsDone({name, profile})) continue;
      if (!frames) frames = ReadRecordedFrames(folder);
      const FieldSurvey survey = SurveyFields(
          {name, *frames, outlines, *AircraftProfile(profile), options_.blindings}, classifier_);
      if (!options_.pictures.empty()) {
        DrawSurvey((std::filesystem::path(options_.pictures) / (name + "-" + profile)).string(),
                   survey,
                   frames->frames);
      }
      Keep(RecordOf(survey));
    }
  }

  bool IsDone(const SurveyKey& key) {
    const std::lock_guard<std::mutex> lock(mutex_);
    return done_.contains(key);
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
  const Classifier& classifier_;
  // Guards the rest, which the jobs share, and the file of the records.
  std::mutex mutex_;
  Json records_;
  std::set<SurveyKey> done_;
  size_t next_ = 0;
  std::exception_ptr failure_;
};

}  // namespace

void FieldCampaignOptions::Check() const {
  if (resumes && json.empty()) throw std::invalid_argument("--resume needs --json");
  for (const std::string& name : aircraft) {
    if (!AircraftProfile(name)) throw std::invalid_argument("--aircraft: no profile " + name);
  }
  PoolOfRun run;
  for (const std::string& folder : flights) {
    const std::string name = std::filesystem::path(folder).filename().string();
    run.Add("flight " + name, EvaluationPools().Of("flight", name));
  }
}

Json RunFieldCampaign(const FieldCampaignOptions& options, const Classifier& classifier) {
  options.Check();
  cv::setNumThreads(1);
  return Campaign(options, classifier).Run();
}

Json MergeFieldReports(const std::vector<Json>& reports) {
  if (reports.empty()) throw std::runtime_error("no report to merge");
  Json records = Json::array();
  std::set<SurveyKey> keys;
  for (const Json& report : reports) {
    if (report.at("settings") != reports.front().at("settings")) {
      throw std::runtime_error("reports of different settings: " + report.at("settings").dump() +
                               " and " + reports.front().at("settings").dump());
    }
    for (const Json& record : report.at("surveys")) {
      if (!keys.insert(KeyOf(record)).second) {
        throw std::runtime_error(KeyOf(record).first + " with " + KeyOf(record).second +
                                 " is in two reports");
      }
      records.push_back(record);
    }
  }
  return ReportOf(reports.front().at("settings"), std::move(records));
}

}  // namespace freelsd
