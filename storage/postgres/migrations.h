// Creates the schema in a PostgreSQL database, and migrates an older one.
#pragma once

#include "storage/postgres/connection.h"

namespace freelsd {

// Applies the migrations that the schema lacks, all in one transaction. One process at a time does
// so; others wait. Throws StorageError kNewer, and changes nothing, if a newer program wrote the
// schema.
//
// A program of the former version would write rows as it knew them: only one that has the database
// alone may migrate a schema that has rows.
bool NeedsMigration(PostgresConnection& connection);
void MigrateDatabase(PostgresConnection& connection);

}  // namespace freelsd
