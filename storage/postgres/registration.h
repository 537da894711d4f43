// A worker among several on one database.
#pragma once

#include <cstdint>

#include "storage/postgres/pool.h"

namespace freelsd {

// Registers this process as a worker. The row goes when the process ends in order, or when another
// worker finds the lease over; the token, which every write compares, is then unknown.
class Registration {
 public:
  Registration(ConnectionPool& pool, double lease_s);
  ~Registration();
  Registration(const Registration&) = delete;
  Registration& operator=(const Registration&) = delete;

  int64_t token() const { return token_; }
  // Within a transaction. Throws StorageError if the registration is gone.
  void Check(PostgresConnection& writer) const;
  // False if the registration is gone.
  bool Renew();
  // Ends the transactions of other workers whose lease is over: one that stands still would keep
  // its row and others for a minute.
  void EndSessionsOfDead();

 private:
  ConnectionPool& pool_;
  double lease_s_;
  int64_t token_;
};

// Deletes other workers whose lease is over, unless one of their writes is going on; their flights
// have no worker then.
void DropDeadWorkers(PostgresConnection& writer, int64_t own_token);

}  // namespace freelsd
