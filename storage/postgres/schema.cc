#include "storage/postgres/schema.h"

#include <string>

extern const char* const kPostgresSchemaSql;

namespace freelsd {
namespace {

// Of schema.sql and of stored JSON, in the table schema_migrations. It rises with each change.
constexpr int64_t kSchemaNumber = 8;

// 0: there is no schema.
int64_t NumberOf(PostgresConnection& connection) {
  const bool is_there =
      connection.Run("SELECT to_regclass('schema_migrations') IS NOT NULL")[0].Bool(0);
  if (!is_there) return 0;
  return connection.Run("SELECT coalesce(max(version), 0) FROM schema_migrations")[0].Int(0);
}

// True if the schema is there.
bool HasSchema(PostgresConnection& connection) {
  const int64_t number = NumberOf(connection);
  if (number == 0 || number == kSchemaNumber) return number != 0;
  throw OtherSchema("open the database", number, kSchemaNumber);
}

void CreateIfMissing(PostgresConnection& connection) {
  // The lock ends with the transaction. Another process may have created it meanwhile.
  connection.Run("SELECT pg_advisory_xact_lock(hashtextextended(current_schema(), 0))");
  if (HasSchema(connection)) return;
  connection.Execute(kPostgresSchemaSql);
  connection.Run("INSERT INTO schema_migrations (version) VALUES ($1)", kSchemaNumber);
}

}  // namespace

void CreateSchema(PostgresConnection& connection) {
  if (HasSchema(connection)) return;
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
