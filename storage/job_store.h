// Jobs: work of the engine that a client requested.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace freelsd {

struct StorageState;

enum class JobState { kQueued, kRunning, kDone, kFailed, kCancelled };

struct JobRow {
  std::string id;
  std::string kind;  // "batch" or "finish"
  std::string flight_id;
  JobState state = JobState::kQueued;
  double progress_ratio = 0.0;
  std::string stage;
  std::string detail_json = "{}";
  int64_t created_at_us = 0;
};

// Invariant: a job that is done, failed or cancelled never changes its state.
class JobStore {
 public:
  explicit JobStore(StorageState& state) : state_(state) {}
  JobStore(const JobStore&) = delete;
  JobStore& operator=(const JobStore&) = delete;

  void Insert(const JobRow& job);
  // Writes state, progress, stage and detail. Does nothing if the stored job has ended.
  void Update(const JobRow& job);
  std::optional<JobRow> Find(const std::string& job_id) const;
  std::vector<JobRow> List() const;                                // newest first, at most 1000
  std::vector<JobRow> ListOf(const std::string& flight_id) const;  // newest first, all
  std::vector<JobRow> ListUnfinished() const;  // queued or running, oldest first
  bool Delete(const std::string& job_id);

 private:
  StorageState& state_;
};

}  // namespace freelsd
