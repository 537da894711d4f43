// Which flights this server works on.
#pragma once

#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "server/jobs/organisations/organisations.h"

namespace freelsd {

// On a shared database: those that it has claimed; else all. Thread-safe.
class Claims {
 public:
  explicit Claims(Organisations& organisations)
      : organisations_(organisations), storage_(organisations.Default().storage) {}

  bool Has(const std::string& flight_id) const;
  // Of the flight's organisation. The flight was claimed, or is one of those listed below.
  Service& ServiceOf(const std::string& flight_id) const;
  // Of the flights that it has, in all organisations. As JobStore::ListUnfinished and
  // FlightStore::ListWithQueuedFrames.
  std::vector<JobRow> UnfinishedJobs() const;
  std::vector<std::string> FlightsWithQueuedFrames() const;
  // Claims one more flight that has work. Nothing if there is none.
  std::optional<Claim> Next();
  // Gives up the flights that have no work, but for those in `kept`.
  void Release(const std::set<std::string>& kept);

 private:
  // Those that may have flights of this server, by name.
  std::map<std::string, Service*> Services() const;
  void Note(const std::string& flight_id, const std::string& organisation) const;

  Organisations& organisations_;
  // Of the claims.
  Storage& storage_;
  // Guards claimed_ and organisation_of_.
  mutable std::mutex mutex_;
  std::set<std::string> claimed_;
  // Of flights that are not the default organisation's.
  mutable std::map<std::string, std::string> organisation_of_;
};

}  // namespace freelsd
