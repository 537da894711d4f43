// Jobs: work of the engine that a client requested.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace freelsd {

enum class JobState { kQueued, kRunning, kDone, kFailed, kCancelled };

struct JobRow {
  // Order of arrival. Insert assigns it.
  int64_t number = 0;
  std::string id;
  std::string kind;  // "batch", "finish" or "replay"
  std::string flight_id;
  JobState state = JobState::kQueued;
  double progress_ratio = 0.0;
  std::string stage;
  std::string detail_json = "{}";
  int64_t created_at_us = 0;
};

struct JobPage {
  std::vector<JobRow> jobs;
  // True if more jobs follow after the last one of this page.
  bool has_more = false;
};

// Invariant: a job that is done, failed or cancelled never changes its state.
class JobStore {
 public:
  virtual ~JobStore() = default;
  JobStore(const JobStore&) = delete;
  JobStore& operator=(const JobStore&) = delete;

  virtual void Insert(const JobRow& job) = 0;
  // False, and nothing is stored, if the flight has an unfinished job of that kind.
  virtual bool InsertAlone(const JobRow& job) = 0;
  // Writes state, progress, stage and detail. Does nothing if the stored job has ended.
  virtual void Update(const JobRow& job) = 0;
  virtual std::optional<JobRow> Find(const std::string& job_id) const = 0;
  // Newest first. The page begins with the job before `before_number`, or with the newest job. It
  // ends early with the job at which the total size of detail_json exceeds `max_bytes`.
  virtual JobPage ListPage(size_t limit,
                           std::optional<int64_t> before_number,
                           size_t max_bytes) const = 0;
  virtual std::vector<JobRow> ListOf(const std::string& flight_id) const = 0;  // newest first, all
  virtual std::vector<JobRow> ListUnfinished() const = 0;  // queued or running, oldest first
  virtual bool Delete(const std::string& job_id) = 0;

 protected:
  JobStore() = default;
};

}  // namespace freelsd
