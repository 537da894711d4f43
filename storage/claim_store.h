// Which process works on which flight, where several share a database.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace freelsd {

struct Claim {
  std::string flight_id;
  // Processes in a row that ended without a word while they had the flight.
  int64_t num_lost = 0;
};

// News for the other processes.
struct SharedEvent {
  // Order of the commits.
  int64_t number = 0;
  std::string type;
  std::string flight_id;
  std::string data;
};

// Of all processes on the database.
struct LeaseCounts {
  // Workers whose lease goes on, and those whose lease is over but nobody has taken note.
  int64_t num_workers = 0;
  int64_t num_expired_workers = 0;
  int64_t num_claimed_flights = 0;
  // Flights that have work and no worker.
  int64_t num_waiting_flights = 0;
};

// A worker (StorageOptions::is_worker) has a lease, which Renew prolongs by the database's clock. A
// worker whose lease is over may lose its claims to others; from then on each of its writes throws
// StorageError and changes nothing. With SQLite, and with a PostgreSQL database that one process
// has for itself, every flight is that process's.
class ClaimStore {
 public:
  virtual ~ClaimStore() = default;
  ClaimStore(const ClaimStore&) = delete;
  ClaimStore& operator=(const ClaimStore&) = delete;

  // False: there is nothing to claim, and no other process to tell.
  virtual bool IsShared() const = 0;
  // Of the flights that have work (queued frames or unfinished jobs) and no living worker, claims
  // the one that was created first. Nothing if there is none.
  virtual std::optional<Claim> ClaimNext() = 0;
  // Flights of this worker, in the order of their creation.
  virtual std::vector<std::string> ListClaimed() const = 0;
  // The worker has done all that it could with the flight.
  virtual void Release(const std::string& flight_id) = 0;
  // False if the lease was over and another worker has taken note.
  virtual bool Renew() = 0;
  virtual LeaseCounts CountLeases() const = 0;

  // Stores an event for other processes. A crash of the database may lose the latest.
  virtual void Tell(const SharedEvent& event) = 0;
  // Events of other processes after that number, oldest first. Waits for up to 250 ms if there are
  // none. For one thread. Those older than ten minutes are gone.
  virtual std::vector<SharedEvent> ListTold(int64_t after_number, int limit) const = 0;
  virtual int64_t LastTold() const = 0;
  virtual void ForgetOldTold() = 0;

 protected:
  ClaimStore() = default;
};

}  // namespace freelsd
