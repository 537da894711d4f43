// The sessions in memory; decides which of them are closed to make room for others.
#pragma once

#include <chrono>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "server/work/flight_session.h"
#include "storage/storage.h"

namespace freelsd {

// Thread-safe.
class OpenFlights {
 public:
  using SessionPointer = std::shared_ptr<FlightSession>;

  OpenFlights(const Storage& storage, int max_num_open)
      : storage_(storage), max_num_open_(static_cast<size_t>(max_num_open)) {}

  SessionPointer Find(const std::string& flight_id) const;
  // True if the flight is open, or if there is room for it and for all that wait longer. If not, it
  // waits from now on.
  bool MayOpen(const std::string& flight_id);
  void Open(const std::string& flight_id, SessionPointer session);
  // Records that the flight had work.
  void Touch(const std::string& flight_id);
  // True if the flight was closed after its last frame was given, and no frame has arrived since.
  // It has no work, although some of its frames still wait for neighbours.
  bool IsParked(const std::string& flight_id);
  // Closes flights that have neither a job nor work, or whose frames have waited for neighbours for
  // long; the least recently used first. Returns their ids.
  std::vector<std::string> CloseIdle(const std::set<std::string>& busy_flights,
                                     const std::set<std::string>& flights_with_jobs);
  void Close(const std::string& flight_id);

 private:
  using Time = std::chrono::steady_clock::time_point;
  struct OpenFlight {
    SessionPointer session;
    Time used_at = std::chrono::steady_clock::now();
  };
  // The caller holds mutex_ in all of these.
  bool IsFull() const { return open_.size() >= max_num_open_; }
  std::vector<std::pair<Time, std::string>> Idle(
      const std::set<std::string>& busy_flights,
      const std::set<std::string>& flights_with_jobs) const;
  void Park(const std::string& flight_id);

  const Storage& storage_;
  size_t max_num_open_;
  // Guards open_, parked_at_ and waiting_.
  mutable std::mutex mutex_;
  std::map<std::string, OpenFlight> open_;
  // By closed flight: sequence number of the last frame that it was given.
  std::map<std::string, int64_t> parked_at_;
  // Flights with work that found no room, the longest waiting first.
  std::deque<std::string> waiting_;
};

}  // namespace freelsd
