#include "server/jobs/worker.h"

#include <algorithm>
#include <set>

#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include "api/import/images/images.h"
#include "api/import/import.h"
#include "server/intake/intake.h"
#include "server/jobs/evaluation.h"
#include "server/jobs/failure.h"
#include "server/jobs/job_json.h"

namespace freelsd {
namespace {

// A full disk has ended an evaluation: it is repeated after this time even if there seems to be no
// more room.
constexpr std::chrono::minutes kEvaluateAgainPeriod{10};
// Least time between two writes of a flight's regions and progress.
constexpr std::chrono::milliseconds kStorePeriod{500};
// How often a server that evaluates leaves flights to others before it claims one.
constexpr int kNumWaitsWhileEvaluating = 2;
// A flight that has ended so many workers in a row is given up.
constexpr int64_t kMaxNumLost = 3;
// Most jobs in last_sequences_.
constexpr size_t kMaxNumKnownJobs = 1000;

bool IsUnresolved(const FrameRow& frame) {
  return frame.resolved_json.empty() && frame.state == FrameState::kQueued;
}

void TellOfFrame(Service& service, const FrameRow& frame) {
  service.events.Publish("frame", frame.flight_id, FrameJson(frame).dump());
}

}  // namespace

Worker::Worker(Service& service, GroundModels ground_models)
    : service_(service),
      config_(service.config),
      ground_models_(std::move(ground_models)),
      claims_(service.storage),
      open_flights_(service.storage, config_.max_num_open_flights),
      frontend_room_(config_.data, kIdlePeriod),
      backend_room_(config_.data, kEvaluateAgainPeriod),
      frontend_thread_([this] { RunFrontend(); }),
      backend_thread_([this] { RunBackend(); }) {}

Worker::~Worker() {
  is_stopping_ = true;
  Wake();
  frontend_thread_.join();
  backend_thread_.join();
}

void Worker::Wake() {
  {
    const std::lock_guard lock(mutex_);
    ++num_wakes_;
  }
  changed_.notify_all();
}

bool Worker::Stop(std::chrono::milliseconds patience) {
  is_stopping_ = true;
  Wake();
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, patience, [this] { return num_running_threads_ == 0; });
}

void Worker::RunFrontend() { Repeat(&Worker::StepFrontend); }

void Worker::RunBackend() { Repeat(&Worker::StepBackend); }

bool Worker::StepFrontend() { return StepWithRoom(&Worker::StepFlights, frontend_room_); }

// Processes one frame of one flight; flights take turns.
bool Worker::StepFlights() {
  const std::vector<JobRow> jobs = claims_.UnfinishedJobs();
  std::set<std::string> busy_flights, flights_with_jobs;
  for (const JobRow& job : jobs) flights_with_jobs.insert(job.flight_id);
  busy_flights = flights_with_jobs;
  for (const std::string& id : claims_.FlightsWithQueuedFrames()) {
    if (flights_with_jobs.contains(id) || !open_flights_.IsParked(id)) busy_flights.insert(id);
  }
  for (const std::string& id : open_flights_.CloseIdle(busy_flights, flights_with_jobs)) Forget(id);
  if (StepOneOf(busy_flights, jobs)) return true;
  // A flight that has just been closed may still be evaluated.
  if (!is_evaluating_) claims_.Release(open_flights_.Ids());
  return ClaimAnother();
}

bool Worker::StepOneOf(const std::set<std::string>& flights, const std::vector<JobRow>& jobs) {
  std::vector<std::string> turns(flights.upper_bound(last_flight_id_), flights.end());
  turns.insert(turns.end(), flights.begin(), flights.upper_bound(last_flight_id_));
  for (const std::string& flight_id : turns) {
    last_flight_id_ = flight_id;
    try {
      if (StepFlight(flight_id, jobs)) {
        open_flights_.Touch(flight_id);
        return true;
      }
    } catch (const StorageError&) {
      throw;
    } catch (const std::exception& error) {
      FailFlight(flight_id, Sentence(error));
      return true;
    }
  }
  return false;
}

// While this server evaluates, others that are idle have the first chance.
bool Worker::ClaimAnother() {
  if (is_evaluating_ && ++num_waits_ < kNumWaitsWhileEvaluating) return false;
  num_waits_ = 0;
  const std::optional<Claim> claim = claims_.Next();
  if (!claim) return false;
  spdlog::info("takes flight {}", claim->flight_id);
  if (claim->num_lost >= kMaxNumLost) {
    FailFlight(claim->flight_id,
               std::to_string(claim->num_lost) + " workers in a row ended while they had it");
  }
  return true;
}

bool Worker::StepFlight(const std::string& flight_id, const std::vector<JobRow>& jobs) {
  const std::optional<FlightRow> flight = service_.storage.flights.Find(flight_id);
  if (!flight) return false;
  if (flight->has_failed) {
    FailFlight(flight_id, "the engine failed on this flight earlier");
    return true;
  }
  if (flight->rig_json.empty()) {
    if (ResolveFirst(*flight)) return true;
    UpdateBatchJobs(flight_id, jobs);
    return false;
  }
  const SessionPointer session = OpenSession(*flight);
  if (!session) return false;
  // A step that failed has left them.
  if (session->HasUnstoredResults()) ApplyResults(flight_id, *session, {});
  std::optional<FrameRow> row = service_.storage.frames.Next(flight_id, session->cursor());
  const std::optional<int64_t> flush_point = session->NextFlushPoint();
  if (flush_point && (!row || row->sequence > *flush_point)) {
    ApplyResults(flight_id, *session, session->Flush(*flush_point));
    StoreProgress(flight_id, *session, jobs);
    Wake();
    return true;
  }
  if (!row) {
    if (!session->IsStored()) StoreProgress(flight_id, *session, jobs);
    UpdateBatchJobs(flight_id, jobs);
    return false;
  }
  PosedFrame frame(std::move(*row));
  if (IsUnresolved(frame.row)) {
    if (ResolveFrame(service_.intake, *flight, frame, MayWait(frame.row)) == Resolution::kWaiting) {
      return false;
    }
    TellOfFrame(service_, frame.row);
  }
  const auto begin = std::chrono::steady_clock::now();
  TakeFrame(flight_id, *session, frame);
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
  service_.progress.AddFrameTime(elapsed.count());
  const bool is_last = !service_.storage.frames.Next(flight_id, session->cursor());
  if (is_last || std::chrono::steady_clock::now() - stored_at_[flight_id] > kStorePeriod) {
    StoreProgress(flight_id, *session, jobs);
  }
  return true;
}

// The first frame with a position determines what the flight's request left open.
bool Worker::ResolveFirst(const FlightRow& flight) {
  const auto sequence = service_.storage.frames.NextQueuedSequence(flight.id, 0);
  std::optional<FrameRow> row;
  if (sequence) row = service_.storage.frames.Next(flight.id, *sequence - 1);
  if (!row) return false;
  PosedFrame frame(std::move(*row));
  if (ResolveFrame(service_.intake, flight, frame, MayWait(frame.row)) == Resolution::kWaiting) {
    return false;
  }
  TellOfFrame(service_, frame.row);
  return true;
}

// Uses the steady clock, which cannot be set.
bool Worker::MayWait(const FrameRow& frame) {
  const auto now = std::chrono::steady_clock::now();
  auto& [sequence, since] = waiting_[frame.flight_id];
  if (sequence != frame.sequence) {
    sequence = frame.sequence;
    since = now;
  }
  return now - since < std::chrono::duration<double>(config_.telemetry_wait_s);
}

// Also takes frames that were processed before a restart, because a replay needs them.
void Worker::TakeFrame(const std::string& flight_id,
                       FlightSession& session,
                       const PosedFrame& frame) {
  // Rejected before it had a position.
  if (!frame.meta) return session.Skip(frame.row.sequence);
  cv::Mat image;
  std::string why_not = "its image file is gone";
  if (const auto bytes = service_.storage.images.Read(frame.row.sha256)) {
    try {
      image = DecodeImage(*bytes, service_.intake.image_limits);
    } catch (const ApiError& error) {
      why_not = error.what();
    }
  }
  if (image.empty()) {
    session.Skip(frame.row.sequence);
    ApplyResults(flight_id, session, {{frame.row.id, false, why_not}});
    return;
  }
  session.GiveWinds(service_.storage, service_.config, *frame.meta);
  ApplyResults(flight_id, session, session.Give(frame.row, *frame.meta, image));
}

void Worker::ApplyResults(const std::string& flight_id,
                          FlightSession& session,
                          const std::vector<FrameResult>& results) {
  session.StoreResults(results, [&](const FrameResult& result) {
    const auto frame = service_.storage.frames.Find(flight_id, result.frame_id);
    const FrameState state = result.is_processed ? FrameState::kProcessed : FrameState::kRejected;
    // A replay may change the stored state, because the frame has more neighbours now.
    if (!frame || frame->state == state) return;
    service_.storage.frames.SetState(flight_id, result.frame_id, state, result.note);
    FrameRow told = *frame;
    told.state = state;
    told.reason = result.note;
    TellOfFrame(service_, told);
    pace_[flight_id].AddFrame();
  });
  if (!IsEvaluationDue(flight_id, session)) return;
  pace_[flight_id].BeginEvaluation();
  due_.Add(flight_id);
  Wake();
}

bool Worker::IsEvaluationDue(const std::string& flight_id, const FlightSession& session) {
  const EvaluationPace& pace = pace_[flight_id];
  const int period = session.request().options.backend.backend_period_frames;
  if (!pace.IsPeriodOver(period)) return false;
  std::optional<int64_t> num_to_finish;
  for (const JobRow& job : service_.storage.jobs.ListUnfinished()) {
    if (job.flight_id != flight_id || job.kind != "finish" || num_to_finish) continue;
    num_to_finish = LastSequence(job) - session.cursor();
  }
  // Nobody waits for the first site of an experiment.
  const bool has_site =
      !session.request().memory.is_kept || service_.storage.sites.HasRecallable(flight_id);
  return pace.IsDue(period, num_to_finish, has_site);
}

void Worker::StoreProgress(const std::string& flight_id,
                           FlightSession& session,
                           const std::vector<JobRow>& jobs) {
  if (!service_.storage.flights.Find(flight_id)) return;
  session.Store(service_.storage);
  service_.events.Publish(
      "region",
      flight_id,
      nlohmann::json{{"flight_id", flight_id},
                     {"num_regions", service_.storage.flights.CountRegions(flight_id)}}
          .dump());
  UpdateBatchJobs(flight_id, jobs);
  stored_at_[flight_id] = std::chrono::steady_clock::now();
}

int64_t Worker::LastSequence(const JobRow& job) {
  const auto known = last_sequences_.find(job.id);
  if (known != last_sequences_.end()) return known->second;
  if (last_sequences_.size() >= kMaxNumKnownJobs) last_sequences_.clear();
  return last_sequences_[job.id] = LastSequenceOf(job, service_.storage);
}

void Worker::UpdateBatchJobs(const std::string& flight_id, const std::vector<JobRow>& jobs) {
  const std::optional<int64_t> next = service_.storage.frames.NextQueuedSequence(flight_id, 0);
  for (JobRow job : jobs) {
    if (job.flight_id != flight_id || job.kind != "batch") continue;
    const int64_t last = LastSequence(job);
    const nlohmann::json detail = nlohmann::json::parse(job.detail_json);
    const double num_frames = std::max(1.0, detail.value("num_accepted", 1.0));
    const bool is_done = !next || *next > last;
    const double num_left = is_done ? 0.0 : static_cast<double>(last - *next + 1);
    job.progress_ratio = std::clamp(1.0 - num_left / num_frames, 0.0, 1.0);
    job.state = is_done ? JobState::kDone : JobState::kRunning;
    job.stage = is_done ? "" : "frontend";
    service_.progress.TellBatch(job.id, job.progress_ratio);
    UpdateJob(service_, job);
  }
}

// A flush ends the waiting of frames for their neighbours. The result of a finish must not depend
// on the sizes of the batches. Therefore no flush may come before the last finish. A session that
// had such a flush is rebuilt. A replay repeats the same flushes. Returns nullptr while too many
// other flights are open.
Worker::SessionPointer Worker::OpenSession(const FlightRow& flight) {
  if (!open_flights_.MayOpen(flight.id)) return nullptr;
  SessionPointer session = open_flights_.Find(flight.id);
  std::vector<int64_t> flush_points;
  int64_t last_finish = 0;
  for (const JobRow& job : service_.storage.jobs.ListOf(flight.id)) {
    flush_points.push_back(LastSequence(job));
    if (job.kind == "finish") last_finish = std::max(last_finish, flush_points.back());
  }
  if (!session || session->HasSettledBefore(last_finish)) {
    session = std::make_shared<FlightSession>(flight, ground_models_);
  }
  for (const int64_t point : flush_points) {
    if (point >= last_finish) session->AddFlushPoint(point);
  }
  open_flights_.Open(flight.id, session);
  return session;
}

void Worker::Forget(const std::string& flight_id) {
  waiting_.erase(flight_id);
  stored_at_.erase(flight_id);
  pace_.erase(flight_id);
}

// Fails the flight and its jobs. Other flights continue.
void Worker::FailFlight(const std::string& flight_id, const std::string& why) {
  spdlog::error("flight {}: {}", flight_id, why);
  service_.storage.flights.Change(flight_id, [&why](FlightRow& flight) {
    if (!flight.has_failed) {
      flight.warnings_json = AddWarnings(flight.warnings_json, "failure", {why});
    }
    flight.has_failed = true;
  });
  for (const FrameRow& frame : service_.storage.frames.List(flight_id)) {
    if (frame.state != FrameState::kQueued) continue;
    service_.storage.frames.SetState(flight_id, frame.id, FrameState::kRejected, why);
  }
  for (const JobRow& job : service_.storage.jobs.ListUnfinished()) {
    if (job.flight_id == flight_id) FailJob(service_, job, why);
  }
  open_flights_.Close(flight_id);
  Forget(flight_id);
}

}  // namespace freelsd
