#include "server/jobs/claims/claims.h"

#include <algorithm>

namespace freelsd {

bool Claims::Has(const std::string& flight_id) const {
  if (!storage_.claims.IsShared()) return true;
  const std::lock_guard lock(mutex_);
  return claimed_.contains(flight_id);
}

void Claims::Note(const std::string& flight_id, const std::string& organisation) const {
  if (organisation == kDefaultOrganisation) return;
  const std::lock_guard lock(mutex_);
  organisation_of_[flight_id] = organisation;
}

Service& Claims::ServiceOf(const std::string& flight_id) const {
  std::string organisation = kDefaultOrganisation;
  {
    const std::lock_guard lock(mutex_);
    const auto found = organisation_of_.find(flight_id);
    if (found != organisation_of_.end()) organisation = found->second;
  }
  return organisations_.Of(organisation);
}

std::map<std::string, Service*> Claims::Services() const {
  std::map<std::string, Service*> services;
  if (!storage_.claims.IsShared()) {
    organisations_.ForEach([&](const std::string& name, Organisation& organisation) {
      services[name] = &organisation.service;
    });
    return services;
  }
  std::set<std::string> names;
  {
    const std::lock_guard lock(mutex_);
    for (const std::string& id : claimed_) {
      const auto found = organisation_of_.find(id);
      names.insert(found == organisation_of_.end() ? kDefaultOrganisation : found->second);
    }
  }
  for (const std::string& name : names) services[name] = &organisations_.Of(name);
  return services;
}

std::vector<JobRow> Claims::UnfinishedJobs() const {
  std::vector<JobRow> all;
  for (const auto& [name, service] : Services()) {
    for (JobRow& job : service->storage.jobs.ListUnfinished()) {
      if (!Has(job.flight_id)) continue;
      Note(job.flight_id, name);
      all.push_back(std::move(job));
    }
  }
  std::sort(
      all.begin(), all.end(), [](const JobRow& a, const JobRow& b) { return a.number < b.number; });
  return all;
}

std::vector<std::string> Claims::FlightsWithQueuedFrames() const {
  std::vector<std::string> all;
  for (const auto& [name, service] : Services()) {
    for (const std::string& id : service->storage.flights.ListWithQueuedFrames()) {
      if (!Has(id)) continue;
      Note(id, name);
      all.push_back(id);
    }
  }
  return all;
}

std::optional<Claim> Claims::Next() {
  std::optional<Claim> claim = storage_.claims.ClaimNext();
  if (!claim) return std::nullopt;
  Note(claim->flight_id, claim->organisation);
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
    organisation_of_.erase(id);
  }
}

}  // namespace freelsd
