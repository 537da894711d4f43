#include "storage/postgres/ownership.h"

#include <string>

namespace freelsd {
namespace {

bool TryLock(PostgresConnection& connection, OwnershipKind kind) {
  const std::string function =
      kind == OwnershipKind::kAlone ? "pg_try_advisory_lock" : "pg_try_advisory_lock_shared";
  return connection
      .Run("SELECT " + function + "(hashtextextended(current_schema() || ' owner', 0))")[0]
      .Bool(0);
}

int64_t Take(PostgresConnection& connection, OwnershipKind kind) {
  if (!TryLock(connection, kind)) {
    throw StorageError("open the database", "another freelsd-server uses it");
  }
  if (kind == OwnershipKind::kShared) return connection.Run("SELECT token FROM owners")[0].Int(0);
  return connection.Run("UPDATE owners SET token = token + 1 RETURNING token")[0].Int(0);
}

}  // namespace

Ownership::Ownership(ConnectionPool& pool, OwnershipKind kind)
    : lease_(pool), token_(Take(*lease_, kind)) {}

void Ownership::Check(PostgresConnection& writer) const {
  const PostgresRows rows = writer.Run("SELECT 1 FROM owners WHERE token = $1 FOR SHARE", token_);
  if (rows.empty()) throw StorageError("write", "another freelsd-server took the database over");
}

}  // namespace freelsd
