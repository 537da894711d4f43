#include "server/jobs/claims/claims.h"

namespace freelsd {

bool Claims::Has(const std::string& flight_id) const {
  if (!storage_.claims.IsShared()) return true;
  const std::lock_guard lock(mutex_);
  return claimed_.contains(flight_id);
}

bool Claims::HasAny() const {
  if (!storage_.claims.IsShared()) return true;
  const std::lock_guard lock(mutex_);
  return !claimed_.empty();
}

std::vector<JobRow> Claims::UnfinishedJobs() const {
  if (!HasAny()) return {};
  std::vector<JobRow> jobs = storage_.jobs.ListUnfinished();
  std::erase_if(jobs, [this](const JobRow& job) { return !Has(job.flight_id); });
  return jobs;
}

std::vector<std::string> Claims::FlightsWithQueuedFrames() const {
  if (!HasAny()) return {};
  std::vector<std::string> flights = storage_.flights.ListWithQueuedFrames();
  std::erase_if(flights, [this](const std::string& id) { return !Has(id); });
  return flights;
}

std::optional<Claim> Claims::Next() {
  std::optional<Claim> claim = storage_.claims.ClaimNext();
  if (!claim) return std::nullopt;
  const std::lock_guard lock(mutex_);
  claimed_.insert(claim->flight_id);
  return claim;
}

void Claims::Release(const std::set<std::string>& kept) {
  if (!storage_.claims.IsShared()) return;
  std::set<std::string> with_work = kept;
  for (const JobRow& job : UnfinishedJobs()) with_work.insert(job.flight_id);
  for (const std::string& id : FlightsWithQueuedFrames()) with_work.insert(id);
  std::set<std::string> idle;
  {
    const std::lock_guard lock(mutex_);
    idle = claimed_;
  }
  for (const std::string& id : with_work) idle.erase(id);
  for (const std::string& id : idle) {
    storage_.claims.Release(id);
    const std::lock_guard lock(mutex_);
    claimed_.erase(id);
  }
}

}  // namespace freelsd
