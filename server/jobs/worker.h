// Runs the engine beside the HTTP threads. One frontend thread processes stored frames in order;
// one backend thread evaluates regions. Both read their work from storage, so that a restart
// continues it.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "server/jobs/claims/claims.h"
#include "server/jobs/evaluation_pace.h"
#include "server/jobs/evaluation_queue.h"
#include "server/jobs/open_flights.h"
#include "server/jobs/room_wait.h"
#include "server/jobs/service.h"

namespace freelsd {

class Worker {
 public:
  Worker(Service& service, GroundModels ground_models);
  // Requires that Stop returned true.
  ~Worker();
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  // Call it after storing new work. Thread-safe.
  void Wake();
  // Ends both threads at their next step. False if one of them is still busy after `patience`.
  bool Stop(std::chrono::milliseconds patience);

 private:
  using SessionPointer = OpenFlights::SessionPointer;
  // Each thread looks for work after this time even if Wake was not called.
  static constexpr std::chrono::seconds kIdlePeriod{2};

  // --- Frontend thread ---
  void RunFrontend();
  bool StepFrontend();
  bool StepFlights();
  // Of what this server has, by flight: one step of the first that has something to do.
  bool StepOneOf(const std::set<std::string>& flights, const std::vector<JobRow>& jobs);
  // Claims a flight that no server works on. False if there is none.
  bool ClaimAnother();
  bool StepFlight(const std::string& flight_id, const std::vector<JobRow>& jobs);
  bool ResolveFirst(const FlightRow& flight);
  // True while the frame may wait for telemetry that gives its position.
  bool MayWait(const FrameRow& frame);
  void TakeFrame(const std::string& flight_id, FlightSession& session, const PosedFrame& frame);
  void ApplyResults(const std::string& flight_id,
                    FlightSession& session,
                    const std::vector<FrameResult>& results);
  bool IsEvaluationDue(const std::string& flight_id, const FlightSession& session);
  void StoreProgress(const std::string& flight_id,
                     FlightSession& session,
                     const std::vector<JobRow>& jobs);
  void UpdateBatchJobs(const std::string& flight_id, const std::vector<JobRow>& jobs);
  SessionPointer OpenSession(const FlightRow& flight);
  // Drops the state of a flight that is not open any more.
  void Forget(const std::string& flight_id);
  void FailFlight(const std::string& flight_id, const std::string& why);
  int64_t LastSequence(const JobRow& job);

  // --- Backend thread ---
  void RunBackend();
  bool StepBackend();
  // Evaluates one flight: for its finish, else its best regions. Flights take turns.
  bool Evaluate();
  // Finish jobs that can run, because the frontend has processed all their frames. Oldest first.
  std::vector<JobRow> ReadyFinishes() const;
  bool IsReadyToFinish(const std::string& flight_id) const;
  void RunFinish(JobRow job, FlightSession& session);
  bool ReplayNext();
  void RunJob(JobRow& job, const std::function<nlohmann::json(const Progress& progress)>& work);
  void RunPeriodic(const std::string& flight_id, FlightSession& session);
  bool TellProgress(double done_ratio);
  // Removes images of idle flights as the settings require.
  void RetireImages();

  // Repeats a step while it finds work; waits otherwise.
  void Repeat(bool (Worker::*step)());
  // Takes the step unless a full disk has ended the last one and there is no more room since.
  bool StepWithRoom(bool (Worker::*step)(), RoomWait& room);
  // The wait is over, if there was one.
  void GoOn(RoomWait& room);
  // Tells the clients of all unfinished jobs that they are held, or go on.
  void TellHeld(const std::optional<std::string>& why);

  Service& service_;
  const Config& config_;
  GroundModels ground_models_;
  Claims claims_;
  OpenFlights open_flights_;
  std::atomic<bool> is_stopping_{false};
  std::atomic<bool> is_evaluating_{false};
  // Each belongs to its thread. A step of the frontend is short.
  RoomWait frontend_room_;
  RoomWait backend_room_;
  std::atomic<int> num_held_{0};

  // Guards num_wakes_ and num_running_threads_.
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  uint64_t num_wakes_ = 0;
  int num_running_threads_ = 2;
  // Flights that have a finish job that can run, or whose best regions are due for an evaluation.
  EvaluationQueue due_;

  // Only the frontend thread uses the next six members.
  int num_waits_ = 0;
  std::string last_flight_id_;
  std::map<std::string, int64_t> last_sequences_;
  std::map<std::string, EvaluationPace> pace_;
  // By flight: sequence number of the frame that waits for telemetry, and the start of its wait.
  std::map<std::string, std::pair<int64_t, std::chrono::steady_clock::time_point>> waiting_;
  std::map<std::string, std::chrono::steady_clock::time_point> stored_at_;

  // The following two belong to the backend thread.
  std::chrono::steady_clock::time_point retired_at_{};
  std::chrono::steady_clock::time_point told_waiting_at_{};

  std::thread frontend_thread_;
  std::thread backend_thread_;
};

}  // namespace freelsd
