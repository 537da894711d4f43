// Who may use a database: one process alone, as a folder lock does for SQLite, or several that
// share.
#pragma once

#include <cstdint>

#include "storage/postgres/pool.h"

namespace freelsd {

enum class OwnershipKind { kAlone, kShared };

// Holds an advisory lock during its lifetime, with a connection of its own. If that connection
// breaks, a process can take the database for itself alone, or others can share it; the token,
// which every write compares, then differs. The constructor changes nothing. It throws StorageError
// if another process has the database for itself, or for kAlone if any has it.
class Ownership {
 public:
  Ownership(ConnectionPool& pool, OwnershipKind kind);
  ~Ownership();
  Ownership(const Ownership&) = delete;
  Ownership& operator=(const Ownership&) = delete;

  // Takes the token. Before the first Check, once the schema is there.
  void Begin();

  // Within a transaction. Throws StorageError if another process took the database for itself.
  void Check(PostgresConnection& writer) const;

 private:
  OwnershipKind kind_;
  ConnectionLease lease_;
  int64_t token_ = 0;
};

}  // namespace freelsd
