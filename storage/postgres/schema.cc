#include "storage/postgres/schema.h"

#include <string>

extern const char* const kPostgresSchema;

namespace freelsd {
namespace {

// Of schema.sql.
constexpr int64_t kSchemaVersion = 8;

// 0: there is none.
int64_t SchemaVersion(PostgresConnection& connection) {
  const bool is_new =
      !connection.Run("SELECT to_regclass('schema_migrations') IS NOT NULL")[0].Bool(0);
  if (is_new) return 0;
  return connection.Run("SELECT coalesce(max(version), 0) FROM schema_migrations")[0].Int(0);
}

void RefuseOther(int64_t version) {
  if (version == kSchemaVersion) return;
  const bool is_newer = version > kSchemaVersion;
  throw StorageError("open the database",
                     std::string(is_newer ? "a newer" : "an older") +
                         " freelsd wrote it: its schema has version " + std::to_string(version) +
                         ", this program needs version " + std::to_string(kSchemaVersion) +
                         "; nothing was changed",
                     is_newer ? StorageFault::kNewer : StorageFault::kOther);
}

void CreateIfMissing(PostgresConnection& connection) {
  // The lock ends with the transaction. Another process may have created the schema meanwhile.
  connection.Run("SELECT pg_advisory_xact_lock(hashtextextended(current_schema(), 0))");
  const int64_t version = SchemaVersion(connection);
  if (version != 0) return RefuseOther(version);
  connection.Execute(
      "CREATE TABLE schema_migrations (version bigint PRIMARY KEY, "
      "applied_at timestamptz NOT NULL DEFAULT now())");
  connection.Execute(kPostgresSchema);
  connection.Run("INSERT INTO schema_migrations (version) VALUES ($1)", kSchemaVersion);
}

}  // namespace

void CreateSchema(PostgresConnection& connection) {
  if (const int64_t version = SchemaVersion(connection)) return RefuseOther(version);
  connection.Execute("BEGIN");
  try {
    CreateIfMissing(connection);
    connection.Execute("COMMIT");
  } catch (const StorageError&) {
    connection.Execute("ROLLBACK");
    throw;
  }
}

}  // namespace freelsd
