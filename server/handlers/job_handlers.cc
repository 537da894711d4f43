#include <algorithm>

#include <nlohmann/json.hpp>

#include "api/api.h"
#include "server/handlers/handlers.h"
#include "server/handlers/lookups.h"
#include "server/handlers/paging.h"
#include "server/http/http.h"
#include "server/intake/intake.h"
#include "server/jobs/jobs.h"

namespace freelsd {
namespace {

// The flight's finish jobs, newest first.
std::vector<JobRow> FinishJobs(const Service& service, const std::string& flight_id) {
  std::vector<JobRow> jobs = service.storage.jobs.ListOf(flight_id);
  std::erase_if(jobs, [](const JobRow& job) { return job.kind != "finish"; });
  return jobs;
}

// The flight's unfinished job of that kind. Another server may have finished it meanwhile.
std::optional<JobRow> UnfinishedJob(const Service& service,
                                    const std::string& flight_id,
                                    const std::string& kind) {
  for (const JobRow& job : service.storage.jobs.ListOf(flight_id)) {
    if (job.kind == kind && IsUnfinished(job)) return job;
  }
  return std::nullopt;
}

// The new job, unless another server was faster: then that server's.
JobRow StoreJob(Service& service, const JobRow& job) {
  while (!service.storage.jobs.InsertAlone(job)) {
    if (const auto running = UnfinishedJob(service, job.flight_id, job.kind)) return *running;
  }
  service.events.Publish("job", job.flight_id, JobJson(service, job).dump());
  return job;
}

// The job that answers this finish: the running one, else a new one. A new one is done at once if
// nothing arrived since the last.
JobRow FinishJob(Service& service, const std::string& flight_id, bool is_over) {
  const std::lock_guard lock(service.intake.intake_mutex);
  const std::vector<JobRow> earlier = FinishJobs(service, flight_id);
  const auto running = std::find_if(earlier.begin(), earlier.end(), IsUnfinished);
  if (running != earlier.end()) return *running;
  const std::vector<FrameRow> frames = service.storage.frames.List(flight_id);
  const int64_t last_sequence = frames.empty() ? 0 : frames.back().sequence;
  const auto done = std::find_if(earlier.begin(), earlier.end(), [](const JobRow& job) {
    return job.state == JobState::kDone;
  });
  // A flight without images cannot be evaluated again; its sites stay.
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
  return StoreJob(service, job);
}

}  // namespace

void PostFinish(Service& service, const Call& call, httplib::Response& response) {
  const FlightRow flight = ExistingFlight(service, call);
  const JobRow job = FinishJob(service, flight.id, flight.has_retired_images);
  service.intake.wake_worker();
  AnswerJob(service, job, response);
}

// A replay of a flight that another one has already asked for is the same.
void PostReplay(Service& service, const Call& call, httplib::Response& response) {
  const FlightRow flight = ExistingFlight(service, call);
  RefuseWhenRetired(flight);
  const std::vector<JobRow> jobs = service.storage.jobs.ListOf(flight.id);
  const bool is_finished = std::any_of(jobs.begin(), jobs.end(), [](const JobRow& job) {
    return job.kind == "finish" && job.state == JobState::kDone;
  });
  if (!is_finished) throw ApiError("Conflict", "no finish of this flight is done");
  if (const auto running = UnfinishedJob(service, flight.id, "replay")) {
    return AnswerJob(service, *running, response);
  }
  JobRow job;
  job.id = NewId("j");
  job.kind = "replay";
  job.flight_id = flight.id;
  job.created_at_us = NowUs();
  const JobRow stored = StoreJob(service, job);
  service.intake.wake_worker();
  AnswerJob(service, stored, response);
}

void GetJobs(Service& service, const Call& call, httplib::Response& response) {
  const JobPage page = service.storage.jobs.ListPage(
      ParseLimit(call), ParseNumberCursor(call), kLimits.answer.max_list_bytes);
  JobView view(service);
  std::string jobs;
  for (const JobRow& job : page.jobs) jobs += (jobs.empty() ? "" : ",") + view.Json(job).dump();
  AnswerPage("jobs",
             jobs,
             page.has_more ? std::optional(page.jobs.back().number) : std::nullopt,
             response);
}

void GetJob(Service& service, const Call& call, httplib::Response& response) {
  response.set_content(JobJson(service, ExistingJob(service, call)).dump(), "application/json");
}

// Cancels an unfinished job and answers it; deletes a finished job.
void DeleteJob(Service& service, const Call& call, httplib::Response& response) {
  JobRow job = ExistingJob(service, call);
  if (IsUnfinished(job)) {
    job.state = JobState::kCancelled;
    UpdateJob(service, job);
    service.intake.wake_worker();
    response.set_content(JobJson(service, ExistingJob(service, call)).dump(), "application/json");
    return;
  }
  service.storage.jobs.Delete(job.id);
  response.status = 204;
}

}  // namespace freelsd
