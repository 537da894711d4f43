// Who may use a database: one process alone, as a folder lock does for SQLite, or several that
// share.
#pragma once

#include <cstdint>

#include "storage/postgres/pool.h"

namespace freelsd {

enum class OwnershipKind { kAlone, kShared };

// Holds an advisory lock during its lifetime, with a connection of its own. If that connection
// breaks, a process can take the database for itself alone; the token, which every write compares,
// then differs. Throws StorageError if another process has the database for itself, or for kAlone
// if any has it.
class Ownership {
 public:
  Ownership(ConnectionPool& pool, OwnershipKind kind);

  // Within a transaction. Throws StorageError if another process took the database for itself.
  void Check(PostgresConnection& writer) const;

 private:
  ConnectionLease lease_;
  int64_t token_;
};

}  // namespace freelsd
