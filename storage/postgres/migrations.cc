#include "storage/postgres/migrations.h"

#include <string>

extern const char* const kPostgresMigrations[];

namespace freelsd {
namespace {

constexpr int64_t kNumMigrations = 7;

int64_t SchemaVersion(PostgresConnection& connection) {
  const bool is_new =
      !connection.Run("SELECT to_regclass('schema_migrations') IS NOT NULL")[0].Bool(0);
  if (is_new) return 0;
  return connection.Run("SELECT coalesce(max(version), 0) FROM schema_migrations")[0].Int(0);
}

void RefuseNewer(int64_t version) {
  if (version <= kNumMigrations) return;
  throw StorageError("open the database",
                     "a newer freelsd wrote it: its schema has version " + std::to_string(version) +
                         ", this program supports versions up to " +
                         std::to_string(kNumMigrations) + "; nothing was changed",
                     StorageFault::kNewer);
}

void ApplyMissing(PostgresConnection& connection) {
  // The lock ends with the transaction. Another process may have migrated meanwhile.
  connection.Run("SELECT pg_advisory_xact_lock(hashtextextended(current_schema(), 0))");
  int64_t version = SchemaVersion(connection);
  RefuseNewer(version);
  if (version == 0) {
    connection.Execute(
        "CREATE TABLE schema_migrations (version bigint PRIMARY KEY, "
        "applied_at timestamptz NOT NULL DEFAULT now())");
  }
  while (version < kNumMigrations) {
    connection.Execute(kPostgresMigrations[version]);
    connection.Run("INSERT INTO schema_migrations (version) VALUES ($1)", ++version);
  }
}

}  // namespace

bool NeedsMigration(PostgresConnection& connection) {
  const int64_t version = SchemaVersion(connection);
  return version > 0 && version < kNumMigrations;
}

void MigrateDatabase(PostgresConnection& connection) {
  const int64_t version = SchemaVersion(connection);
  RefuseNewer(version);
  if (version == kNumMigrations) return;
  connection.Execute("BEGIN");
  try {
    ApplyMissing(connection);
    connection.Execute("COMMIT");
  } catch (const StorageError&) {
    connection.Execute("ROLLBACK");
    throw;
  }
}

}  // namespace freelsd
