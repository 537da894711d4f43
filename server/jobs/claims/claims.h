// Which flights this server works on.
#pragma once

#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "storage/storage.h"

namespace freelsd {

// On a shared database: those that it has claimed; else all. Thread-safe.
class Claims {
 public:
  explicit Claims(Storage& storage) : storage_(storage) {}

  bool Has(const std::string& flight_id) const;
  // Of the flights that it has. As JobStore::ListUnfinished and FlightStore::ListWithQueuedFrames.
  std::vector<JobRow> UnfinishedJobs() const;
  std::vector<std::string> FlightsWithQueuedFrames() const;
  // Claims one more flight that has work. Nothing if there is none.
  std::optional<Claim> Next();
  // Gives up the flights that have no work, but for those in `kept`.
  void Release(const std::set<std::string>& kept);

 private:
  // False: the database need not be asked for work.
  bool HasAny() const;

  Storage& storage_;
  // Guards claimed_.
  mutable std::mutex mutex_;
  std::set<std::string> claimed_;
};

}  // namespace freelsd
