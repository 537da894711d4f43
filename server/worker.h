// Runs the engine beside the HTTP threads: one frontend thread takes stored frames in order, one
// backend thread evaluates regions. What is to be done is always read from storage, so a restart
// goes on by itself.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "server/open_flights.h"
#include "server/service.h"

namespace freelsd {

class Worker {
 public:
  Worker(Service& service, Classifier classifier);
  // Stop must have answered true.
  ~Worker();
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  // Something new is in storage.
  void Wake();
  // Ends both threads at their next step. False when one is still busy after this time.
  bool Stop(std::chrono::milliseconds patience);

 private:
  using SessionPointer = OpenFlights::SessionPointer;

  // --- Frontend thread ---
  void RunFrontend();
  bool StepFrontend();
  bool StepFlight(const std::string& flight_id, const std::vector<JobRow>& jobs);
  bool ResolveFirst(const FlightRow& flight);
  // Whether a frame may wait on for telemetry that tells its position.
  bool MayWait(const FrameRow& frame);
  void TakeFrame(const std::string& flight_id, FlightSession& session, const FrameRow& frame);
  void ApplyResults(const std::string& flight_id,
                    FlightSession& session,
                    const std::vector<FrameResult>& results);
  void StoreProgress(const std::string& flight_id,
                     FlightSession& session,
                     const std::vector<JobRow>& jobs);
  void UpdateBatchJobs(const std::string& flight_id, const std::vector<JobRow>& jobs);
  SessionPointer OpenSession(const FlightRow& flight);
  // What is only remembered of open flights.
  void Forget(const std::string& flight_id);
  void FailFlight(const std::string& flight_id, const std::string& why);
  int64_t LastSequence(const JobRow& job);

  // --- Backend thread ---
  void RunBackend();
  bool StepBackend();
  void RunFinish(JobRow job, FlightSession& session);
  void RunPeriodic(const std::string& flight_id, FlightSession& session);
  // Removes images of flights that are over, as far as the settings ask for it.
  void RetireImages();

  // Repeats a step while it has something to do; waits otherwise.
  void Repeat(bool (Worker::*step)());

  Service& service_;
  Classifier classifier_;
  OpenFlights open_flights_;
  std::atomic<bool> is_stopping_{false};

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  uint64_t num_wakes_ = 0;
  int num_running_threads_ = 2;
  // Flights whose best regions are due for an evaluation.
  std::set<std::string> due_;

  // Frontend thread only.
  std::string last_flight_id_;
  std::map<std::string, int64_t> last_sequences_;
  std::map<std::string, int> num_since_evaluation_;
  // By flight: the frame that waits for telemetry, and since when.
  std::map<std::string, std::pair<int64_t, std::chrono::steady_clock::time_point>> waiting_;
  std::map<std::string, std::chrono::steady_clock::time_point> stored_at_;

  // Backend thread only.
  std::chrono::steady_clock::time_point retired_at_{};

  std::thread frontend_thread_;
  std::thread backend_thread_;
};

}  // namespace freelsd
