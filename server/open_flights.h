// The sessions that are in memory, and which of them give way to others.
#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "server/flight_session.h"
#include "storage/storage.h"

namespace freelsd {

// Thread-safe.
class OpenFlights {
 public:
  using SessionPointer = std::shared_ptr<FlightSession>;

  OpenFlights(const Storage& storage, int max_num_open)
      : storage_(storage), max_num_open_(static_cast<size_t>(max_num_open)) {}

  SessionPointer Find(const std::string& flight_id) const;
  // Whether it is open, or not as many others are as may be.
  bool HasRoomFor(const std::string& flight_id) const;
  void Open(const std::string& flight_id, SessionPointer session);
  // There was something to do for it.
  void Touch(const std::string& flight_id);
  // Whether it was closed after all its frames were given, some of which wait in vain: nothing to
  // do before there are more.
  bool IsParked(const std::string& flight_id);
  // Of flights without a job those that have nothing to do, or whose frames have long waited for
  // others; those used last stay longest. Answers which.
  std::vector<std::string> CloseIdle(const std::set<std::string>& busy_flights,
                                     const std::set<std::string>& flights_with_jobs);
  void Close(const std::string& flight_id);

 private:
  using Time = std::chrono::steady_clock::time_point;
  struct OpenFlight {
    SessionPointer session;
    Time used_at = std::chrono::steady_clock::now();
  };
  // All with the lock held.
  bool IsFull() const { return open_.size() >= max_num_open_; }
  std::vector<std::pair<Time, std::string>> Idle(
      const std::set<std::string>& busy_flights,
      const std::set<std::string>& flights_with_jobs) const;
  void Park(const std::string& flight_id);

  const Storage& storage_;
  size_t max_num_open_;
  mutable std::mutex mutex_;
  std::map<std::string, OpenFlight> open_;
  // By flight that was closed: the last frame it was given.
  std::map<std::string, int64_t> parked_at_;
};

}  // namespace freelsd
