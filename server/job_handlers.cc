#include <algorithm>

#include <nlohmann/json.hpp>

#include "api/api.h"
#include "server/flight_lookup.h"
#include "server/handlers.h"
#include "server/job_json.h"
#include "server/stamps.h"

namespace freelsd {
namespace {

constexpr const char* kStateNames[] = {"queued", "running", "done", "failed", "cancelled"};

bool IsUnfinished(const JobRow& job) {
  return job.state == JobState::kQueued || job.state == JobState::kRunning;
}

JobRow ExistingJob(const Service& service, const Call& call) {
  const std::optional<JobRow> job = service.storage.FindJob(call.Id("job"));
  if (!job) throw ApiError("NoSuchJob", "there is no such job");
  return *job;
}

// Newest first.
std::vector<JobRow> FinishJobs(const Service& service, const std::string& flight_id) {
  std::vector<JobRow> jobs = service.storage.ListJobsOf(flight_id);
  std::erase_if(jobs, [](const JobRow& job) { return job.kind != "finish"; });
  return jobs;
}

// The job that answers this finish: the one that runs, or a new one, done already where nothing
// came since the last.
JobRow FinishJob(Service& service, const std::string& flight_id, bool is_over) {
  const std::lock_guard lock(service.intake_mutex);
  const std::vector<JobRow> earlier = FinishJobs(service, flight_id);
  const auto running = std::find_if(earlier.begin(), earlier.end(), IsUnfinished);
  if (running != earlier.end()) return *running;
  const std::vector<FrameRow> frames = service.storage.ListFrames(flight_id);
  const int64_t last_sequence = frames.empty() ? 0 : frames.back().sequence;
  const auto done = std::find_if(earlier.begin(), earlier.end(), [](const JobRow& job) {
    return job.state == JobState::kDone;
  });
  // Without its images a flight cannot be looked at again; what was found stays.
  const bool is_nothing_new =
      frames.empty() || is_over ||
      (done != earlier.end() && LastSequenceOf(*done, service.storage) == last_sequence);
  JobRow job;
  job.id = NewId("j");
  job.kind = "finish";
  job.flight_id = flight_id;
  job.created_at_us = NowUs();
  job.detail_json = nlohmann::json{{"last_sequence", last_sequence}}.dump();
  if (is_nothing_new) {
    job.state = JobState::kDone;
    job.progress_ratio = 1.0;
  }
  service.storage.InsertJob(job);
  service.events.Publish("job", flight_id, JobJson(job).dump());
  return job;
}

}  // namespace

nlohmann::json JobJson(const JobRow& job) {
  const std::string flight = "/v1/flights/" + job.flight_id;
  nlohmann::json result{{"flight", flight}};
  if (job.kind == "finish") result["sites"] = flight + "/sites";
  if (job.kind == "batch") result["frames"] = flight + "/frames";
  return {{"id", job.id},
          {"kind", job.kind},
          {"flight_id", job.flight_id},
          {"state", kStateNames[static_cast<int>(job.state)]},
          {"progress", job.progress_ratio},
          {"stage", job.stage},
          {"detail", nlohmann::json::parse(job.detail_json)},
          {"result", result},
          {"created_at", Rfc3339(job.created_at_us)}};
}

void UpdateJob(Service& service, const JobRow& job) {
  service.storage.UpdateJob(job);
  service.events.Publish("job", job.flight_id, JobJson(job).dump());
}

void AnswerJob(const JobRow& job, httplib::Response& response) {
  response.status = 202;
  response.set_header("Location", "/v1/jobs/" + job.id);
  response.set_content(JobJson(job).dump(), "application/json");
}

int64_t LastSequenceOf(const JobRow& job, const Storage& storage) {
  const nlohmann::json detail = nlohmann::json::parse(job.detail_json);
  if (job.kind == "finish") return detail.value("last_sequence", int64_t{0});
  int64_t last_sequence = 0;
  for (const nlohmann::json& image : detail.value("images", nlohmann::json::array())) {
    const auto frame = storage.FindFrame(job.flight_id, image.value("id", ""));
    if (frame) last_sequence = std::max(last_sequence, frame->sequence);
  }
  return last_sequence;
}

void PostFinish(Service& service, const Call& call, httplib::Response& response) {
  const FlightRow flight = ExistingFlight(service, call);
  const JobRow job = FinishJob(service, flight.id, flight.has_retired_images);
  service.wake_worker();
  AnswerJob(job, response);
}

void GetJobs(Service& service, const Call&, httplib::Response& response) {
  nlohmann::json jobs = nlohmann::json::array();
  for (const JobRow& job : service.storage.ListJobs()) jobs.push_back(JobJson(job));
  response.set_content(nlohmann::json{{"jobs", jobs}}.dump(), "application/json");
}

void GetJob(Service& service, const Call& call, httplib::Response& response) {
  response.set_content(JobJson(ExistingJob(service, call)).dump(), "application/json");
}

// An unfinished job is cancelled and answered; a finished one is forgotten.
void DeleteJob(Service& service, const Call& call, httplib::Response& response) {
  JobRow job = ExistingJob(service, call);
  if (IsUnfinished(job)) {
    job.state = JobState::kCancelled;
    UpdateJob(service, job);
    service.wake_worker();
    response.set_content(JobJson(ExistingJob(service, call)).dump(), "application/json");
    return;
  }
  service.storage.DeleteJob(job.id);
  response.status = 204;
}

}  // namespace freelsd
