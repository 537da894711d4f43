#include "storage/postgres/ownership.h"

#include <string>

namespace freelsd {
namespace {

bool CallOnLock(PostgresConnection& connection, const std::string& function, OwnershipKind kind) {
  const std::string suffix = kind == OwnershipKind::kAlone ? "" : "_shared";
  return connection
      .Run("SELECT " + function + suffix + "(hashtextextended(current_schema() || ' owner', 0))")[0]
      .Bool(0);
}

}  // namespace

Ownership::Ownership(ConnectionPool& pool, OwnershipKind kind) : kind_(kind), lease_(pool) {
  if (!CallOnLock(*lease_, "pg_try_advisory_lock", kind)) {
    throw StorageError("open the database", "another freelsd-server uses it");
  }
}

Ownership::~Ownership() {
  try {
    CallOnLock(*lease_, "pg_advisory_unlock", kind_);
  } catch (const StorageError&) {
    // The lock ended with its connection.
    return;
  }
}

void Ownership::Begin() {
  if (kind_ == OwnershipKind::kAlone) {
    lease_->Run("UPDATE owners SET token = token + 1, is_alone = true");
  } else {
    // Who had it alone, and does not know yet that its lock is gone, writes nothing more.
    lease_->Run("UPDATE owners SET token = token + 1, is_alone = false WHERE is_alone");
  }
  token_ = lease_->Run("SELECT token FROM owners")[0].Int(0);
}

void Ownership::Check(PostgresConnection& writer) const {
  const PostgresRows rows = writer.Run("SELECT 1 FROM owners WHERE token = $1 FOR SHARE", token_);
  if (rows.empty()) throw StorageError("write", "another freelsd-server took the database over");
}

}  // namespace freelsd
