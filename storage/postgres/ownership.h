// Gives one process a database for itself, as a folder lock does for SQLite.
#pragma once

#include <cstdint>

#include "storage/postgres/pool.h"

namespace freelsd {

// Holds an advisory lock during its lifetime, with a connection of its own. If that connection
// breaks, another process can take the database; the token, which every write compares, then
// differs. Throws StorageError if another process has the database.
class Ownership {
 public:
  explicit Ownership(ConnectionPool& pool);

  // Within a transaction. Throws StorageError if another process took the database.
  void Check(PostgresConnection& writer) const;

 private:
  ConnectionLease lease_;
  int64_t token_;
};

}  // namespace freelsd
