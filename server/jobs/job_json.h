// Converts jobs to JSON for clients, and reads values from their detail_json.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "server/http/http.h"
#include "server/jobs/service.h"

namespace freelsd {

// Jobs as api/openapi.yaml describes them, at one moment: what runs, and what comes before what
// waits. For one answer, by one thread.
class JobView {
 public:
  explicit JobView(const Service& service);
  nlohmann::json Json(const JobRow& job);

 private:
  // What a person who waits for a job wants to know. `stage_title` and `summary` are plain English.
  struct Outlook {
    std::string stage_title;
    std::string summary;
    std::optional<double> time_left_s;
    // Nothing unless another flight's evaluation comes first.
    bool waits_for_evaluation = false;
  };
  bool RunsElsewhere(const JobRow& job) const;
  Outlook OutlookOf(const JobRow& job);
  Outlook OutlookOfRunning(const JobRow& job, std::optional<double> time_left_s) const;
  Outlook OutlookOfWaiting(const JobRow& job);
  // Time until the frontend has processed the flight's frames up to this one, if all flights with
  // photographs, which take turns, have as many; 0 if it has.
  std::optional<double> FramesLeftS(const std::string& flight_id, int64_t last_sequence);
  // Time until the evaluations before this job's are done: the one that runs, and those of older
  // jobs.
  std::optional<double> EvaluationsAheadS(const JobRow& job);
  const std::string& NameOfEvaluated();
  // Oldest first.
  const std::vector<JobRow>& Unfinished();

  const Service& service_;
  std::optional<std::string> why_held_;
  std::optional<EvaluationNow> evaluation_;
  // The following two are read when they are first needed.
  std::optional<std::vector<JobRow>> unfinished_;
  std::optional<std::string> name_of_evaluated_;
};

// One job, now.
nlohmann::json JobJson(const Service& service, const JobRow& job);
// Stores the job and publishes an event.
void UpdateJob(Service& service, const JobRow& job);
// Answers 202 with the job.
void AnswerJob(const Service& service, const JobRow& job, httplib::Response& response);
// True if it is queued or runs.
bool IsUnfinished(const JobRow& job);
// Sequence number of the last frame that the job waits for; 0 if it waits for none.
int64_t LastSequenceOf(const JobRow& job, const Storage& storage);

}  // namespace freelsd
