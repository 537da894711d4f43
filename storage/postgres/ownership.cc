#include "storage/postgres/ownership.h"

namespace freelsd {
namespace {

int64_t Take(PostgresConnection& connection) {
  const bool is_free = connection
                           .Run(
                               "SELECT pg_try_advisory_lock(hashtextextended(current_schema() "
                               "|| ' owner', 0))")[0]
                           .Bool(0);
  if (!is_free) throw StorageError("open the database", "another freelsd-server uses it");
  return connection.Run("UPDATE owners SET token = token + 1 RETURNING token")[0].Int(0);
}

}  // namespace

Ownership::Ownership(ConnectionPool& pool) : lease_(pool), token_(Take(*lease_)) {}

void Ownership::Check(PostgresConnection& writer) const {
  const PostgresRows rows = writer.Run("SELECT 1 FROM owners WHERE token = $1 FOR SHARE", token_);
  if (rows.empty()) throw StorageError("write", "another freelsd-server took the database over");
}

}  // namespace freelsd
