// The methods of Worker that the backend thread calls, and how both threads repeat their steps.
#include <algorithm>

#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include "server/intake/intake.h"
#include "server/jobs/evaluation.h"
#include "server/jobs/failure.h"
#include "server/jobs/heap.h"
#include "server/jobs/job_json.h"
#include "server/jobs/replay/replay.h"
#include "server/jobs/retention.h"
#include "server/jobs/worker.h"

namespace freelsd {
namespace {

constexpr std::chrono::milliseconds kProgressPeriod{300};
constexpr std::chrono::seconds kRetirePeriod{30};
// Time between two events of a finish that waits, and the largest number of such jobs that have
// events.
constexpr std::chrono::seconds kWaitingPeriod{2};
constexpr int kMaxNumWaitingTold = 20;

// Stores a job's progress. is_wanted() is false once the job is cancelled or deleted.
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
    const std::optional<JobRow> stored = service_.storage.jobs.Find(job_.id);
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

// Sets a mark during its lifetime.
class Mark {
 public:
  explicit Mark(std::atomic<bool>& mark) : mark_(mark) { mark_ = true; }
  ~Mark() { mark_ = false; }
  Mark(const Mark&) = delete;
  Mark& operator=(const Mark&) = delete;

 private:
  std::atomic<bool>& mark_;
};

}  // namespace

void Worker::TellHeld(const std::optional<std::string>& why) {
  service_.progress.SetHeld(why);
  JobView view(service_);
  for (const JobRow& job : service_.storage.jobs.ListUnfinished()) {
    service_.events.Publish("job", job.flight_id, view.Json(job).dump());
  }
}

void Worker::GoOn(RoomWait& room) {
  if (!room.IsBegun()) return;
  room.End();
  if (--num_held_ == 0) TellHeld(std::nullopt);
}

bool Worker::StepWithRoom(bool (Worker::*step)(), RoomWait& room) {
  if (!room.MayTry()) return false;
  if (room.HasMore()) GoOn(room);
  try {
    const bool has_worked = (this->*step)();
    GoOn(room);
    return has_worked;
  } catch (const StorageError& error) {
    if (error.fault != StorageFault::kFull) throw;
    // What was only tried is held as before.
    const bool is_held = room.IsBegun();
    room.Begin();
    if (is_held) return false;
    ++num_held_;
    spdlog::error("worker: {}; {}", error.what(), RoomWait::kReason);
    TellHeld(RoomWait::kReason);
    return false;
  }
}

void Worker::Repeat(bool (Worker::*step)()) {
  GiveWay();
  while (!is_stopping_) {
    uint64_t seen = 0;
    {
      const std::lock_guard lock(mutex_);
      seen = num_wakes_;
    }
    bool has_worked = false;
    try {
      has_worked = (this->*step)();
    } catch (const StorageError& error) {
      // A full disk or an I/O error: the next step retries after the idle period.
      if (error.fault == StorageFault::kDamaged) service_.storage.MarkDamaged(error.what());
      spdlog::error("worker: {}", error.what());
    } catch (const std::exception& error) {
      spdlog::error("worker: {}", error.what());
    }
    if (has_worked) continue;
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, kIdlePeriod, [&] { return num_wakes_ != seen || is_stopping_; });
  }
  const std::lock_guard lock(mutex_);
  --num_running_threads_;
  changed_.notify_all();
}

std::vector<JobRow> Worker::ReadyFinishes() const {
  std::vector<JobRow> ready;
  for (const JobRow& job : claims_.UnfinishedJobs()) {
    if (job.kind != "finish") continue;
    const SessionPointer session = open_flights_.Find(job.flight_id);
    const int64_t last_sequence = LastSequenceOf(job, service_.storage);
    if (!session || session->flushed_through() < last_sequence) continue;
    if (session->HasUnstoredResults() || session->HasSettledBefore(last_sequence)) continue;
    ready.push_back(job);
  }
  return ready;
}

bool Worker::IsReadyToFinish(const std::string& flight_id) const {
  const std::vector<JobRow> ready = ReadyFinishes();
  return std::any_of(
      ready.begin(), ready.end(), [&](const JobRow& job) { return job.flight_id == flight_id; });
}

bool Worker::StepBackend() {
  // First, because it makes room on a full disk.
  RetireImages();
  return StepWithRoom(&Worker::Evaluate, backend_room_);
}

bool Worker::Evaluate() {
  const std::vector<JobRow> finishes = ReadyFinishes();
  for (const JobRow& job : finishes) due_.Add(job.flight_id);
  // Before the flight is looked up: what is evaluated is not released.
  const Mark mark(is_evaluating_);
  const std::optional<std::string> flight_id = due_.Take();
  if (!flight_id) return ReplayNext();
  const SessionPointer session = open_flights_.Find(*flight_id);
  if (!session) return true;
  const auto finish = std::find_if(finishes.begin(), finishes.end(), [&](const JobRow& job) {
    return job.flight_id == *flight_id;
  });
  if (finish == finishes.end()) {
    RunPeriodic(*flight_id, *session);
  } else {
    RunFinish(*finish, *session);
    ReturnFreedMemory();
  }
  return true;
}

void Worker::RunFinish(JobRow job, FlightSession& session) {
  EvaluationMark mark(
      service_.progress, EvaluationKind::kFinish, job.flight_id, job.id, session.flushed_through());
  RunJob(job, [&](const Progress& progress) {
    const EvaluationCount evaluated =
        EvaluateFlight(service_, job.flight_id, session, EvaluationScope::kEveryGraded, progress);
    mark.is_complete = true;
    return nlohmann::json{{"num_sites", evaluated.num_sites},
                          {"through_sequence", evaluated.through_sequence}};
  });
}

// Runs the oldest replay that waits. False if none does.
bool Worker::ReplayNext() {
  for (JobRow& job : claims_.UnfinishedJobs()) {
    if (job.kind != "replay") continue;
    const auto num_frames =
        static_cast<int64_t>(service_.storage.frames.List(job.flight_id).size());
    EvaluationMark mark(
        service_.progress, EvaluationKind::kReplay, job.flight_id, job.id, num_frames);
    RunJob(job, [&](const Progress& progress) {
      nlohmann::json replayed = ReplayFlight(service_, job.flight_id, ground_models_, progress);
      mark.is_complete = true;
      return replayed;
    });
    ReturnFreedMemory();
    return true;
  }
  return false;
}

// `work` returns what the job's detail says in the end.
void Worker::RunJob(JobRow& job,
                    const std::function<nlohmann::json(const Progress& progress)>& work) {
  job.state = JobState::kRunning;
  UpdateJob(service_, job);
  JobProgress progress(service_, job);
  try {
    const nlohmann::json result = work([&](double ratio, const std::string& stage) {
      TellProgress(ratio);
      return !is_stopping_ && progress.Tell(ratio, stage);
    });
    nlohmann::json detail = nlohmann::json::parse(job.detail_json);
    detail.update(result);
    job.detail_json = detail.dump();
    job.state = JobState::kDone;
    job.progress_ratio = 1.0;
    job.stage.clear();
    UpdateJob(service_, job);
  } catch (const StorageError&) {
    throw;
  } catch (const std::exception& error) {
    // While the server stops, the job stays unfinished: the next start continues it.
    if (is_stopping_ || !progress.is_wanted()) return;
    spdlog::error("job {}: {}", job.id, Sentence(error));
    FailJob(service_, job, Sentence(error));
  }
}

void Worker::RunPeriodic(const std::string& flight_id, FlightSession& session) {
  EvaluationMark mark(
      service_.progress, EvaluationKind::kPeriodic, flight_id, "", session.flushed_through());
  bool is_overtaken = false;
  try {
    EvaluateFlight(service_,
                   flight_id,
                   session,
                   EvaluationScope::kBest,
                   [&](double ratio, const std::string&) {
                     if (TellProgress(ratio)) is_overtaken = IsReadyToFinish(flight_id);
                     return !is_stopping_ && !is_overtaken;
                   });
    mark.is_complete = true;
  } catch (const StorageError&) {
    throw;
  } catch (const std::exception& error) {
    // The finish evaluates the same ground and more.
    if (is_stopping_ || is_overtaken) return;
    spdlog::error("flight {}: {}", flight_id, Sentence(error));
    service_.storage.flights.Change(flight_id, [&error](FlightRow& flight) {
      flight.warnings_json = AddWarnings(flight.warnings_json, "evaluation", {Sentence(error)});
    });
  }
}

// Also tells the clients of finishes that wait, because their times depend on this evaluation.
// Returns whether it was time to.
bool Worker::TellProgress(double done_ratio) {
  service_.progress.TellEvaluation(done_ratio);
  const auto now = std::chrono::steady_clock::now();
  if (now - told_waiting_at_ < kWaitingPeriod) return false;
  told_waiting_at_ = now;
  JobView view(service_);
  int num_told = 0;
  for (const JobRow& job : service_.storage.jobs.ListUnfinished()) {
    if (job.kind != "finish" || job.state != JobState::kQueued) continue;
    service_.events.Publish("job", job.flight_id, view.Json(job).dump());
    if (++num_told == kMaxNumWaitingTold) break;
  }
  return true;
}

void Worker::RetireImages() {
  const auto now = std::chrono::steady_clock::now();
  if (retired_at_ != std::chrono::steady_clock::time_point{} && now - retired_at_ < kRetirePeriod) {
    return;
  }
  retired_at_ = now;
  for (const std::string& id : FlightsToRetire(service_)) {
    if (!service_.storage.flights.RetireImages(id)) continue;
    open_flights_.Close(id);
    spdlog::info("removed the images of flight {} to free disk space", id);
  }
  for (const std::string& id : FlightsToRetirePicturesOf(service_)) {
    spdlog::info("removed the picture of the ground of flight {} to free disk space", id);
    service_.storage.maps.RemovePhotoTiles(id);
  }
}

}  // namespace freelsd
