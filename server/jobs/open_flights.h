// The flight sessions in memory. Decides which of them are closed to free memory.
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

#include "server/jobs/flight_session.h"
#include "storage/storage.h"

namespace freelsd {

// Thread-safe.
class OpenFlights {
 public:
  using SessionPointer = std::shared_ptr<FlightSession>;

  OpenFlights(const Storage& storage, int max_num_open)
      : storage_(storage), max_num_open_(static_cast<size_t>(max_num_open)) {}

  std::set<std::string> Ids() const;
  SessionPointer Find(const std::string& flight_id) const;
  // True if the flight is open, or if there is room for it and for all flights that wait longer. If
  // false, the flight waits from now on.
  bool MayOpen(const std::string& flight_id);
  void Open(const std::string& flight_id, SessionPointer session);
  // Records that the flight was just processed.
  void Touch(const std::string& flight_id);
  // True if the flight was closed after all its frames were passed to the engine, and no frame has
  // arrived since. Such a flight needs no processing, although some of its frames may still wait
  // for neighbours.
  bool IsParked(const std::string& flight_id);
  // Closes idle flights, the least recently used first. A flight is closed if another flight needs
  // the room, if too many flights have been idle for long, or if the flight was deleted. A flight
  // is idle if it has no job and is not busy. A busy flight that makes no progress for long counts
  // as idle. Returns the ids of the closed flights.
  std::vector<std::string> CloseIdle(const std::set<std::string>& busy_flights,
                                     const std::set<std::string>& flights_with_jobs);
  void Close(const std::string& flight_id);

 private:
  using Time = std::chrono::steady_clock::time_point;
  struct OpenFlight {
    SessionPointer session;
    Time used_at = std::chrono::steady_clock::now();
  };
  // The caller holds mutex_.
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
  // Key: id of a closed flight. Value: sequence number of the last frame that its session received.
  std::map<std::string, int64_t> parked_at_;
  // Flights that have work and wait for room. The flight that waits longest is first.
  std::deque<std::string> waiting_;
};

}  // namespace freelsd
