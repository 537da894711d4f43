// The backend thread's half of Worker.
#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include "server/evaluation.h"
#include "server/failure.h"
#include "server/heap.h"
#include "server/job_json.h"
#include "server/retention.h"
#include "server/warnings.h"
#include "server/worker.h"

namespace freelsd {
namespace {

constexpr std::chrono::milliseconds kProgressPeriod{300};
constexpr std::chrono::seconds kRetirePeriod{30};

// Tells the job's row how far it is; answers false once it is cancelled or gone.
class JobProgress {
 public:
  JobProgress(Service& service, JobRow& job) : service_(service), job_(job) {}

  bool Tell(double done_ratio, const std::string& stage) {
    const auto now = std::chrono::steady_clock::now();
    if (now - told_at_ < kProgressPeriod && stage == job_.stage) return is_wanted_;
    told_at_ = now;
    job_.progress_ratio = done_ratio;
    job_.stage = stage;
    UpdateJob(service_, job_);
    const std::optional<JobRow> stored = service_.storage.FindJob(job_.id);
    is_wanted_ = stored && stored->state == JobState::kRunning;
    return is_wanted_;
  }
  bool is_wanted() const { return is_wanted_; }

 private:
  Service& service_;
  JobRow& job_;
  std::chrono::steady_clock::time_point told_at_{};
  bool is_wanted_ = true;
};

}  // namespace

std::string Sentence(const std::exception& error) {
  if (const auto* const opencv = dynamic_cast<const cv::Exception*>(&error)) {
    // Its what() names source files.
    return "image processing failed: " + std::string(opencv->err);
  }
  return error.what();
}

void FailJob(Service& service, JobRow job, const std::string& why) {
  nlohmann::json detail = nlohmann::json::parse(job.detail_json);
  detail["message"] = why;
  job.detail_json = detail.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  job.state = JobState::kFailed;
  UpdateJob(service, job);
}

// The oldest finish whose frames are all through the frontend, else a flight that is due.
bool Worker::StepBackend() {
  RetireImages();
  for (const JobRow& job : service_.storage.ListUnfinishedJobs()) {
    if (job.kind != "finish") continue;
    const SessionPointer session = open_flights_.Find(job.flight_id);
    const int64_t last_sequence = LastSequenceOf(job, service_.storage);
    if (!session || session->flushed_through() < last_sequence) continue;
    if (session->HasSettledBefore(last_sequence)) continue;
    RunFinish(job, *session);
    ReturnFreedMemory();
    return true;
  }
  std::string flight_id;
  {
    const std::lock_guard lock(mutex_);
    if (due_.empty()) return false;
    flight_id = *due_.begin();
    due_.erase(due_.begin());
  }
  const SessionPointer session = open_flights_.Find(flight_id);
  if (session) RunPeriodic(flight_id, *session);
  return true;
}

void Worker::RunFinish(JobRow job, FlightSession& session) {
  job.state = JobState::kRunning;
  UpdateJob(service_, job);
  JobProgress progress(service_, job);
  try {
    const size_t num_sites = EvaluateFlight(service_,
                                            job.flight_id,
                                            session,
                                            EvaluationScope::kEveryGraded,
                                            [&](double ratio, const std::string& stage) {
                                              return !is_stopping_ && progress.Tell(ratio, stage);
                                            });
    nlohmann::json detail = nlohmann::json::parse(job.detail_json);
    detail["num_sites"] = num_sites;
    job.detail_json = detail.dump();
    job.state = JobState::kDone;
    job.progress_ratio = 1.0;
    job.stage.clear();
    UpdateJob(service_, job);
  } catch (const StorageError&) {
    throw;
  } catch (const std::exception& error) {
    // A stopping server leaves the job as it is: the next start goes on with it.
    if (is_stopping_ || !progress.is_wanted()) return;
    spdlog::error("job {}: {}", job.id, Sentence(error));
    FailJob(service_, job, Sentence(error));
  }
}

void Worker::RunPeriodic(const std::string& flight_id, FlightSession& session) {
  try {
    EvaluateFlight(
        service_, flight_id, session, EvaluationScope::kBest, [this](double, const std::string&) {
          return !is_stopping_;
        });
  } catch (const StorageError&) {
    throw;
  } catch (const std::exception& error) {
    if (is_stopping_) return;
    spdlog::error("flight {}: {}", flight_id, Sentence(error));
    service_.storage.ChangeFlight(flight_id, [&error](FlightRow& flight) {
      flight.warnings_json = AddWarnings(flight.warnings_json, "evaluation", {Sentence(error)});
    });
  }
}

void Worker::RetireImages() {
  const auto now = std::chrono::steady_clock::now();
  if (retired_at_ != std::chrono::steady_clock::time_point{} && now - retired_at_ < kRetirePeriod) {
    return;
  }
  retired_at_ = now;
  for (const std::string& id : FlightsToRetire(service_)) {
    open_flights_.Close(id);
    spdlog::info("images of flight {} are removed to make room", id);
    service_.storage.RetireImages(id);
  }
}

}  // namespace freelsd
